//! This bench program beside another one, by turns: what a change costs, whatever the machine does meanwhile.
//!
//! Each bench runs in a process of its own, the two programs one after the other, the first of a round the second of the next. A
//! row's figure is the median CPU time over the rounds. The other program needs no more than to print rows as this one does.

use super::head::Failure;
use super::measure::median;
use std::path::Path;
use std::process::Command;

/// What is more than this times the other program's is named at the end.
const ALLOWED: f64 = 1.10;

/// CPU milliseconds of a row, by program and round.
struct Row {
    name: String,
    cpu: [Vec<f64>; 2],
}

/// Name and CPU milliseconds, if a line is a row: two figures with one decimal after a name.
fn row(line: &str) -> Option<(String, f64)> {
    let figure = |word: &str| word.split_once('.').filter(|(_, decimals)| decimals.len() == 1).and(word.parse().ok());
    let words: Vec<&str> = line.split_whitespace().collect();
    let at = words.windows(2).position(|pair| pair.iter().all(|word| figure(word).is_some()))?;
    (at > 0).then(|| Some((words[..at].join(" "), figure(words[at + 1])?)))?
}

/// The rows of one bench of a program, and what it complained of.
fn rows(program: &Path, bench: &str) -> Result<Vec<(String, f64)>, Failure> {
    let done = Command::new(program).args(["--bench", bench]).output()?;
    let said = String::from_utf8_lossy(&done.stdout);
    if !done.status.success() {
        let last = said.lines().last().unwrap_or_default();
        return Err(format!("{}: {last} {}", program.display(), String::from_utf8_lossy(&done.stderr)).into());
    }
    Ok(said.lines().filter_map(row).collect())
}

/// Runs benches of this program and of `other` by turns and prints a line for each row.
pub fn run(other: &Path, benches: &[&str], rounds: usize) -> Result<(), Failure> {
    let programs = [std::env::current_exe()?, other.canonicalize().map_err(|e| format!("{}: {e}", other.display()))?];
    println!("CPU ms, median of {rounds} rounds by turns; beside: {}", programs[1].display());
    println!("{:<44} {:>10} {:>10} {:>7}   rounds", "operation", "this", "beside", "ratio");
    let mut over = Vec::new();
    for bench in benches {
        let mut all: Vec<Row> = Vec::new();
        'rounds: for round in 0..rounds {
            // The other one first: a bench that it lacks is not run at all.
            for which in if round % 2 == 0 { [1, 0] } else { [0, 1] } {
                let found = match rows(&programs[which], bench) {
                    Ok(found) => found,
                    Err(error) => {
                        println!("{bench}: {error}");
                        break 'rounds;
                    }
                };
                if round == 0 && which == 1 && found.is_empty() {
                    println!("{bench}: no rows beside it");
                    break 'rounds;
                }
                for (name, cpu) in found {
                    match all.iter_mut().find(|r| r.name == name) {
                        Some(row) => row.cpu[which].push(cpu),
                        None => {
                            let mut row = Row { name, cpu: [Vec::new(), Vec::new()] };
                            row.cpu[which].push(cpu);
                            all.push(row);
                        }
                    }
                }
            }
        }
        for Row { name, cpu } in all {
            let [this, beside] = &cpu;
            if this.is_empty() || beside.is_empty() {
                println!("{name:<44} only {}", if beside.is_empty() { "in this program" } else { "beside" });
                continue;
            }
            let ratio = median(this.clone()) / median(beside.clone());
            let each: Vec<f64> = this.iter().zip(beside).map(|(a, b)| a / b).collect();
            let (least, most) = each.iter().fold((f64::INFINITY, 0.0_f64), |(lo, hi), &r| (lo.min(r), hi.max(r)));
            let [a, b] = [this, beside].map(|t| median(t.clone()));
            println!("{name:<44} {a:>10.1} {b:>10.1} {ratio:>7.2}   {least:.2} to {most:.2}");
            if ratio > ALLOWED {
                over.push(format!("{name} {ratio:.2}"));
            }
        }
    }
    println!("over {ALLOWED:.2}: {}", if over.is_empty() { "none".to_owned() } else { over.join(", ") });
    Ok(())
}
