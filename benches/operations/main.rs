//! Benchmarks: one an operation. `cargo bench` runs all, `cargo bench -- draw` those whose name has "draw".
//!
//! `BURIN_PEERS=DIR` names a folder of other programs' results (JSON lines); a ratio to the matching row is then printed.
//! Every timed picture is compared with one that was drawn untimed.
#![allow(missing_docs)]

mod cube;
mod dense;
mod draw;
mod explode;
mod export;
mod head;
mod measure;
mod open;
mod paint;
mod save;
mod settle;
mod slices;
mod undo;
mod window;

use measure::Report;

type Bench = (&'static str, fn(&mut Report) -> Result<(), Box<dyn std::error::Error>>);

const BENCHES: &[Bench] = &[
    ("draw/modes", draw::modes),
    ("draw/exploded", draw::exploded),
    ("draw/unexploded", draw::unexploded),
    ("draw/plain", draw::plain),
    ("draw/pool", draw::pool),
    ("paint/dab", paint::dab),
    ("paint/stamp", paint::stamp),
    ("undo/stroke", undo::undo),
    ("slices/pictures", slices::slices),
    ("explode/settle", settle::settle),
    ("explode/visibility", explode::visibility),
    ("explode/pictures", explode::pictures),
    ("keep/save", save::save),
    ("keep/export", export::export),
    ("open/memory", open::memory),
    ("window/frame", window::frame),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(child) = arguments.iter().position(|a| a == open::CHILD) {
        return open::child(&arguments[child + 1..]);
    }
    // `cargo test --all-targets` starts benches too, without this flag.
    if !arguments.iter().any(|a| a == "--bench") {
        return;
    }
    let filter = arguments.iter().find(|a| !a.starts_with('-')).cloned().unwrap_or_default();
    let mut report = Report::new();
    for (name, bench) in BENCHES.iter().filter(|(name, _)| name.contains(&filter)) {
        if let Err(error) = bench(&mut report) {
            println!("{name}: {error}");
            std::process::exit(1);
        }
    }
}
