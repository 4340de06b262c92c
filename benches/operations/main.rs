//! Benchmarks: one an operation. `cargo bench` runs all, `cargo bench -- draw` those whose name has "draw";
//! `cargo bench -- --beside PROGRAM [draw]` runs them by turns with another build of this program, five rounds or `--rounds N`;
//! `--check` is what `tools/gpu` runs.
//!
//! `BURIN_PEERS=DIR` names a folder of other programs' results (JSON lines); a ratio to the matching row is then printed.
//! Every timed picture is compared with one that was drawn untimed.
#![allow(missing_docs)]

mod annotations;
mod beside;
mod check;
mod components;
mod cube;
mod dense;
mod draw;
mod explode;
mod export;
mod head;
mod looks;
mod marks;
mod measure;
mod open;
mod paint;
mod refined;
mod save;
mod settle;
mod slices;
mod stroke;
mod ten;
mod trace;
mod undo;
mod window;

use measure::Report;

type Bench = (&'static str, fn(&mut Report) -> Result<(), Box<dyn std::error::Error>>);

const BENCHES: &[Bench] = &[
    ("draw/modes", draw::modes),
    ("draw/exploded", draw::exploded),
    ("draw/unexploded", draw::unexploded),
    ("draw/forms", draw::forms),
    ("draw/plain", draw::plain),
    ("draw/pool", draw::pool),
    ("draw/refine", explode::refine),
    ("draw/looks", looks::labels),
    ("draw/ten", ten::volumes),
    ("paint/dab", paint::dab),
    ("paint/click", paint::click),
    ("paint/box_click", paint::click_in_box),
    ("paint/stamp", paint::stamp),
    ("paint/stroke", stroke::running),
    ("undo/stroke", undo::undo),
    ("slices/pictures", slices::slices),
    ("trace/grids", trace::grids),
    ("trace/relaxed", annotations::relaxed),
    ("draw/annotations", annotations::fifty),
    ("explode/settle", settle::settle),
    ("explode/visibility", explode::visibility),
    ("explode/pictures", explode::pictures),
    ("paint/refined", refined::boxes),
    ("segment/components", components::components),
    ("segment/isolate", components::isolate),
    ("segment/surfaces", components::surfaces),
    ("keep/save", save::save),
    ("keep/export", export::export),
    ("open/memory", open::memory),
    ("window/frame", window::frame),
    ("card/marks", marks::marks),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(child) = arguments.iter().position(|a| a == open::CHILD) {
        return open::child(&arguments[child + 1..]);
    }
    // `cargo test --all-targets` starts benches too, without this flag.
    let has = |flag: &str| arguments.iter().any(|a| a == flag);
    if has("--check") || has("--find") {
        std::process::exit(checked(&arguments));
    }
    if !has("--bench") {
        return;
    }
    let [beside, rounds] = ["--beside", "--rounds"].map(|option| arguments.iter().position(|a| a == option));
    let value = |option: Option<usize>| option.and_then(|at| arguments.get(at + 1));
    let is_value = |i: usize| [beside, rounds].iter().flatten().any(|at| at + 1 == i);
    let filter = arguments.iter().enumerate().find(|(i, a)| !a.starts_with('-') && !is_value(*i));
    let filter = filter.map(|(_, a)| a.clone()).unwrap_or_default();
    if beside.is_some() {
        let names: Vec<&str> = BENCHES.iter().map(|(name, _)| *name).filter(|name| name.contains(&filter)).collect();
        let count = value(rounds).and_then(|n| n.parse().ok()).unwrap_or(5);
        let other = value(beside).map(std::path::Path::new).ok_or("--beside: a bench program expected after it");
        if let Err(error) = other.map_err(Into::into).and_then(|other| beside::run(other, &names, count)) {
            println!("{error}");
            std::process::exit(1);
        }
        return;
    }
    let mut report = Report::new();
    for (name, bench) in BENCHES.iter().filter(|(name, _)| name.contains(&filter)) {
        if let Err(error) = bench(&mut report) {
            println!("{name}: {error}");
            std::process::exit(1);
        }
    }
}

/// `--check`: the exit code.
fn checked(arguments: &[String]) -> i32 {
    let benches: Vec<&str> = BENCHES.iter().map(|(name, _)| *name).collect();
    match check::Options::parse(arguments) {
        Err(words) => {
            println!("{words}");
            check::USAGE
        }
        Ok(options) => check::check(&options, &benches).unwrap_or_else(|error| {
            println!("{error}");
            check::FAILED
        }),
    }
}
