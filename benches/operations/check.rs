//! The check of a graphics card: every bench and the picture tests on one adapter, and a report of what was found.
//!
//! Every bench and the tests run in processes of their own, so that a driver that fails one leaves the report with the others. What
//! was found so far is in the file at any time.

use super::head::{Failure, root};
use burin::gpu::{AdapterChoice, Gpu, GpuError};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What `tools/gpu` and a bundle's `run` end with.
pub const FAILED: i32 = 1;
pub const USAGE: i32 = 2;
pub const NO_CARD: i32 = 3;

/// Names of tests that draw and paint on the device and compare with oracles.
const PICTURES: [&str; 5] =
    ["gpu::", "explode::picture", "document::pictures", "document::exploded", "document::surface"];
/// Of these, what reads the sources.
const SOURCES: [&str; 4] = ["--skip", "gpu::without", "--skip", "gpu::shader"];

#[derive(Debug)]
pub struct Options {
    adapter: AdapterChoice,
    report: PathBuf,
    tests: Option<PathBuf>,
    only: String,
    find: bool,
}

impl Options {
    /// From `--any-adapter`, `--adapter NAME`, `--report FILE`, `--tests PROGRAM`, `--only NAME`.
    pub fn parse(arguments: &[String]) -> Result<Self, String> {
        let (report, only) = (PathBuf::from("gpu-report.md"), String::new());
        let mut options = Self { adapter: AdapterChoice::Hardware, report, tests: None, only, find: false };
        let mut words = arguments.iter();
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word}: a value expected after it, found none"));
            match word.as_str() {
                "--any-adapter" => options.adapter = AdapterChoice::Best,
                "--adapter" => options.adapter = AdapterChoice::from_words(value()?),
                "--report" => options.report = value()?.into(),
                "--tests" => options.tests = Some(value()?.into()),
                "--only" => options.only = value()?.clone(),
                "--find" => options.find = true,
                "--check" | "--bench" => {}
                other => {
                    return Err(format!(
                        "{other} found, --any-adapter, --adapter NAME, --report FILE or --only NAME (benches whose name has it) expected"
                    ));
                }
            }
        }
        Ok(options)
    }

    /// A program that uses the chosen adapter.
    fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        command.env("BURIN_ADAPTER", self.adapter.words()).env_remove("BURIN_WITHOUT_GPU");
        command
    }
}

/// The report so far, in memory and in its file.
struct Paper {
    path: PathBuf,
    text: String,
}

impl Paper {
    fn say(&mut self, text: &str) -> Result<(), Failure> {
        println!("{text}");
        self.text.push_str(text);
        self.text.push('\n');
        std::fs::write(&self.path, &self.text).map_err(|e| format!("{}: {e}", self.path.display()).into())
    }
}

/// Adapter, driver, processor and program; a device is made for trial.
fn header(options: &Options) -> Result<String, GpuError> {
    let gpu = Gpu::headless_of(&options.adapter)?;
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        cpu.lines().find(|l| l.starts_with("model name")).and_then(|l| l.split(": ").nth(1)).unwrap_or("unknown");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let revision = std::env::var("BURIN_REVISION").unwrap_or_else(|_| "unknown".into());
    Ok(format!(
        "# Burin on {}\n- adapter and driver: {}\n- processor: {model}, {cores} threads, {} {}\n- program: Burin {}, revision {revision}",
        gpu.name(),
        gpu.describe(),
        std::env::consts::OS,
        std::env::consts::ARCH,
        env!("CARGO_PKG_VERSION"),
    ))
}

/// Runs a bench; answers its lines and whether it went well.
fn bench(options: &Options, name: &str) -> Result<(String, bool), Failure> {
    let done = options.command(&std::env::current_exe()?).args(["--bench", name]).current_dir(root()).output()?;
    let said = String::from_utf8_lossy(&done.stdout);
    let mut lines: String =
        said.lines().filter(|l| !l.starts_with("operation ")).fold(String::new(), |all, line| all + line + "\n");
    if !done.status.success() {
        let why = String::from_utf8_lossy(&done.stderr);
        let _ = writeln!(lines, "{name} FAILED, {}: {}", done.status, why.lines().last().unwrap_or_default());
    }
    Ok((lines.trim_end().to_owned(), done.status.success()))
}

/// Runs the picture tests and tells what failed and how far pictures were from their oracles.
fn tests(options: &Options, program: &Path, paper: &mut Paper) -> Result<bool, Failure> {
    let folder = tempfile::tempdir()?;
    let differences = folder.path().join("differences");
    let done = options
        .command(program)
        .args(PICTURES)
        .args(SOURCES)
        .env("BURIN_DIFFERENCES", &differences)
        .env("RUST_BACKTRACE", "0")
        .current_dir(root())
        .output()
        .map_err(|e| format!("{}: {e}", program.display()))?;
    let said = String::from_utf8_lossy(&done.stdout);
    let count = |end: &str| said.lines().filter(|l| l.starts_with("test ") && l.ends_with(end)).count();
    let (passed, failed) = (count("... ok"), count("... FAILED"));
    paper.say(&format!("{passed} passed, {failed} failed, {}.\n", done.status))?;
    let mut worst: BTreeMap<String, (f64, f64, usize)> = BTreeMap::new();
    for line in std::fs::read_to_string(&differences).unwrap_or_default().lines() {
        let Ok(told) = serde_json::from_str::<Value>(line) else { continue };
        let (largest, mean) = (told["largest"].as_f64().unwrap_or(f64::NAN), told["mean"].as_f64().unwrap_or(f64::NAN));
        let of = worst.entry(told["test"].as_str().unwrap_or("?").to_owned()).or_default();
        *of = (of.0.max(largest), of.1.max(mean), of.2 + 1);
    }
    paper.say("Largest difference of a picture from its oracle, in 8-bit steps of its largest channel, and the largest mean:\n")?;
    paper.say("| test | pictures | largest | mean |\n| --- | --- | --- | --- |")?;
    for (test, (largest, mean, pictures)) in worst {
        paper.say(&format!("| {test} | {pictures} | {largest:.3} | {mean:.4} |"))?;
    }
    if let Some((_, why)) = said.split_once("\nfailures:\n") {
        paper.say(&format!("\n```\n{}\n```", why.trim()))?;
    }
    if passed + failed == 0 {
        paper.say(&format!("\n```\n{}\n```", String::from_utf8_lossy(&done.stderr).trim()))?;
    }
    Ok(done.status.success() && passed > 0)
}

/// Writes the report; answers the exit code.
pub fn check(options: &Options, benches: &[&str]) -> Result<i32, Failure> {
    let head = match header(options) {
        Ok(head) => head,
        Err(GpuError::NoAdapter { reason }) => {
            println!(
                "No adapter to check: {reason}. `--any-adapter` checks the one that there is, a software one too."
            );
            return Ok(NO_CARD);
        }
        Err(error) => return Err(error.into()),
    };
    if options.find {
        println!("{head}");
        return Ok(0);
    }
    let mut paper = Paper { path: std::path::absolute(&options.report)?, text: String::new() };
    paper.say(&head)?;
    paper.say("\n## Benches\nMilliseconds of wall time, of all CPU threads, and what they lie beside.\n\n```")?;
    let mut well = true;
    let named = |name: &&&str| name.contains(options.only.as_str());
    for name in benches.iter().filter(named) {
        let (lines, good) = bench(options, name)?;
        paper.say(&lines)?;
        well &= good;
    }
    paper.say("```")?;
    if let Some(program) = &options.tests {
        paper.say("\n## Picture tests")?;
        well &= tests(options, program, &mut paper)?;
    }
    println!("\nThe report is in {}", paper.path.display());
    Ok(if well { 0 } else { FAILED })
}
