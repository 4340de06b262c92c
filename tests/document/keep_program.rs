//! The program itself, killed at seeded moments while it does a script: what is found is what it had answered for, or one
//! command more. With an adapter it paints real strokes. `BURIN_KILLS` sets how often (20).

use super::keep_kill::kills;
use super::keep_support::difference;
use super::maker::{run, write_nrrd};
use crate::common::gpu::gpu;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Grid;
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command as Process, Stdio};
use std::time::{Duration, Instant};

fn line(rng: &mut ChaCha8Rng, volume: &Path, strokes: bool) -> String {
    let n: f64 = rng.random_range(1.0..150.0);
    let around = |rng: &mut ChaCha8Rng| [0; 3].map(|_| rng.random_range(-1.0..1.0));
    let lines = [
        json!({"selection":{"import":{"path":volume,"threshold":n,"soften_mm":n / 40.0}}}),
        json!({"selection":{"clear":{}}}),
        json!({"segment":{"set":{"id":n as u16,"name":format!("segment {n}")}}}),
        json!({"part":{"split":{"by":{"plane":{"point":around(rng).map(|v: f64| 20.0 + 5.0 * v),"normal":around(rng)}}}}}),
        json!({"part":{"reset":{}}}),
        json!({"explosion":{"seed":{"value":n as u64}}}),
        json!({"view":{"window":{"level":n,"width":7.0}}}),
        json!({"view":{"orbit":{"azimuth_deg":n,"elevation_deg":3.0}}}),
        json!({"brush":{"set":{"radius_mm":n}}}),
        json!({"history":{"undo":{}}}),
        json!({"history":{"undo":{"steps":2}}}),
        json!({"history":{"redo":{}}}),
        json!({"project":{"save":{}}}),
        json!({"project":{"save":{}}}),
    ];
    let points: Vec<Value> = (0..3)
        .map(|_| json!({"at":{"mm":around(rng).map(|v: f64| 24.0 + 14.0 * v)},"pressure":rng.random_range(0.2..1.0)}))
        .collect();
    let target = match rng.random_range(0..4) {
        0 => json!({"selection":1.0}),
        1 => json!({"label":3}),
        2 => json!({"colour":[1.0,0.5,0.0,0.75]}),
        _ => json!({"density":n}),
    };
    let painted = [
        json!({"brush":{"set":{"target":target,"radius_mm":n / 15.0}}}),
        json!({"stroke":{"paint":{"points":points}}}),
        json!({"stroke":{"paint":{"points":points}}}),
        json!({"stroke":{"begin":{"points":points}}}),
        json!({"stroke":{"extend":{"points":points}}}),
        json!({"stroke":{"end":{}}}),
    ];
    let from = if strokes && rng.random_range(0..2) == 0 { &painted[..] } else { &lines[..] };
    from.choose(rng).unwrap().to_string()
}

fn opened(project: &Path) -> Document {
    let mut document = Document::new();
    let answer = run(&mut document, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
    assert_eq!(answer["warnings"], json!([]));
    document
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let place = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &place);
        } else {
            std::fs::copy(entry.path(), place).unwrap();
        }
    }
}

#[test]
fn a_killed_script_loses_at_most_the_command_in_progress() {
    let dir = tempfile::tempdir().unwrap();
    let (volume, base) = (dir.path().join("v.nrrd"), dir.path().join("base"));
    write_nrrd(&volume, &Grid::aligned([40, 36, 34], DVec3::new(1.0, 1.25, 1.5), DVec3::splat(4.0)), |v| {
        (v[0] * 3 + v[2]) as f32
    });
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
    run(&mut document, &json!({"project":{"save":{"path":base}}}).to_string()).unwrap();
    drop(document);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let adapter = gpu();
    let (mut commands, mut saves, mut ahead) = (0, 0, 0);
    for round in 0..kills() {
        let (project, mirror) = (dir.path().join(format!("p{round}")), dir.path().join(format!("m{round}")));
        copy(&base, &project);
        let script: Vec<String> = (0..40).map(|_| line(&mut rng, &volume, adapter.is_some())).collect();
        let mut child = Process::new(crate::common::program())
            .args(["run", "-", "--keep-going", "--project"])
            .arg(&project)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // Stays open: a script that ends is not killed.
        let mut stdin = child.stdin.take().unwrap();
        stdin.write_all((script.join("\n") + "\n").as_bytes()).unwrap();
        let mut answers = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
        // Every other time up to a save, which is under way then.
        let first_save =
            script.iter().position(|line| line.contains("\"save\"")).filter(|at| *at > 0 && round % 2 == 0);
        let wait_for = first_save.map_or_else(|| rng.random_range(1..24), |at| at - 1);
        let mut said: Vec<String> = answers.by_ref().take(1).collect();
        let start = Instant::now();
        said.extend(answers.by_ref().take(wait_for));
        if first_save.is_some() {
            std::thread::sleep(Duration::from_micros(rng.random_range(0..2000)));
        } else {
            std::thread::sleep((start.elapsed() / wait_for as u32).mul_f64(rng.random_range(0.0..2.0)));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        said.extend(answers);
        let answered = said.iter().filter(|a| serde_json::from_str::<Value>(a).is_ok()).count();
        assert!(answered > 0, "round {round}: {said:?}");

        let found = opened(&project);
        let found = found.state().unwrap();
        // After a number of commands; with a stroke running, its beginning may have made a segment or widened the density.
        let wrong_after = |count: usize| {
            let mut first = None;
            for ending in ["", r#"{"stroke":{"cancel":{}}}"#, r#"{"stroke":{"end":{}}}"#] {
                let _ = std::fs::remove_dir_all(&mirror);
                copy(&base, &mirror);
                let mut expected = opened(&mirror);
                if let Some(gpu) = &adapter {
                    expected.use_gpu(gpu.clone());
                }
                for command in &script[..count] {
                    let _ = run(&mut expected, command);
                }
                let painting = expected.is_painting();
                if !ending.is_empty() {
                    run(&mut expected, ending).unwrap();
                }
                let wrong = difference(expected.state().unwrap(), found)?;
                first.get_or_insert(wrong);
                if !painting {
                    break;
                }
            }
            first
        };
        let mut wrong = wrong_after(answered);
        if wrong.is_some() && answered < script.len() {
            wrong = wrong_after(answered + 1);
            ahead += 1;
        }
        if let Some(what) = wrong {
            let last = &script[answered.saturating_sub(2)..(answered + 1).min(script.len())];
            panic!("round {round}, {answered} commands answered, around {last:?}: {what}");
        }
        commands += answered;
        saves += script.get(answered).is_some_and(|c| c.contains("save")) as u64;
        drop(stdin);
        std::fs::remove_dir_all(&project).unwrap();
        std::fs::remove_dir_all(&mirror).unwrap();
    }
    assert!(saves > 0 || kills() < 4, "no kill fell into a save");
    println!("{} kills over {commands} commands: {saves} before a save was answered, {ahead} a command ahead", kills());
}
