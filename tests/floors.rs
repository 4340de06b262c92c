//! The house's floors: imports go down only, neighbours on a floor do not import each other, and each outside library stays
//! on its own floor.

use std::path::{Path, PathBuf};

/// Ground to roof; modules of one entry are neighbours.
const FLOORS: &[&[&str]] = &[
    &["math"],
    &["volume"],
    &["io", "paint", "segment", "explode", "annotate", "mesh"],
    &["gpu"],
    &["document"],
    &["interact"],
    &["script", "ui"],
    &["main"],
];

/// Where a library may be named, as a prefix of the path below `src`.
const LIBRARIES: &[(&str, &[&str])] = &[
    ("wgpu", &["gpu/", "ui/views/viewport"]),
    ("naga", &["gpu/"]),
    ("naga_oil", &["gpu/"]),
    ("egui", &["ui/"]),
    ("eframe", &["ui/"]),
    ("rapier3d", &["explode/bodies"]),
    ("zarrs", &["document/"]),
];

fn sources(dir: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

fn floor_of(module: &str) -> Option<usize> {
    FLOORS.iter().position(|f| f.contains(&module))
}

/// Code without comments and string literals, so that words in prose count for nothing.
fn code(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let mut rest = line;
        let mut kept = String::new();
        while let Some(quote) = rest.find('"') {
            kept.push_str(&rest[..quote]);
            let after = &rest[quote + 1..];
            let mut end = after.len();
            let mut escaped = false;
            for (i, c) in after.char_indices() {
                match c {
                    '\\' if !escaped => escaped = true,
                    '"' if !escaped => {
                        end = i + 1;
                        break;
                    }
                    _ => escaped = false,
                }
            }
            rest = &after[end.min(after.len())..];
        }
        kept.push_str(rest);
        out.push_str(kept.split("//").next().unwrap_or(""));
        out.push('\n');
    }
    out
}

/// Every `crate::module` and `burin::module` that a file names, grouped imports included.
fn named_modules(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for root in ["crate::", "burin::"] {
        for (at, _) in code.match_indices(root) {
            let rest = &code[at + root.len()..];
            if let Some(group) = rest.strip_prefix('{') {
                let mut depth = 1;
                let mut word = String::new();
                let mut at_start = true;
                for c in group.chars() {
                    match c {
                        '{' => depth += 1,
                        '}' => depth -= 1,
                        ',' if depth == 1 => {
                            found.push(std::mem::take(&mut word));
                            at_start = true;
                            continue;
                        }
                        _ => {}
                    }
                    if depth == 0 {
                        break;
                    }
                    if depth == 1 && at_start {
                        if c.is_alphanumeric() || c == '_' {
                            word.push(c);
                        } else if !word.is_empty() {
                            at_start = false;
                        }
                    }
                }
                found.push(word);
            } else {
                found.push(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
            }
        }
    }
    found
}

/// What is wrong with a file, in sentences.
fn faults(path: &str, text: &str) -> Vec<String> {
    let code = code(text);
    let module = path.split(['/', '.']).next().unwrap_or("");
    let mut faults = Vec::new();
    if let Some(own) = floor_of(module) {
        for name in named_modules(&code) {
            if let Some(other) = floor_of(&name)
                && name != module
                && other >= own
            {
                faults.push(format!("{path} imports {name}, which is not on a floor below"));
            }
        }
    } else if module != "lib" {
        faults.push(format!("{path}: module {module} has no floor"));
    }
    for (library, places) in LIBRARIES {
        let names = |c: &str| {
            c.match_indices(&format!("{library}::"))
                .any(|(i, _)| !c[..i].ends_with(|b: char| b.is_alphanumeric() || b == '_' || b == ':'))
        };
        if names(&code) && !places.iter().any(|p| path.starts_with(p)) {
            faults.push(format!("{path} names {library}, which belongs in {places:?}"));
        }
    }
    faults
}

#[test]
fn imports_go_down_only_and_libraries_stay_on_their_floor() {
    let root = crate::common::root().join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    assert!(files.len() > 20, "sources not found");
    let found: Vec<String> = files
        .iter()
        .flat_map(|f| {
            let path = f.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
            faults(&path, &std::fs::read_to_string(f).unwrap())
        })
        .collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_forbidden_import_is_found() {
    let up = "use crate::{math::Ray,\n    gpu::{Gpu, Caster}};";
    assert_eq!(faults("paint/dab.rs", up).len(), 1);
    assert_eq!(faults("paint/dab.rs", "fn f() { crate::explode::split(); }").len(), 1);
    assert_eq!(faults("document/mod.rs", "use wgpu::Device;").len(), 1);
    assert_eq!(faults("ui/app.rs", "let d: wgpu::Device;").len(), 1);
    assert_eq!(faults("annex/mod.rs", "").len(), 1);
    assert!(faults("gpu/pool.rs", "use crate::volume::Field; use wgpu::Device; // crate::ui").is_empty());
    assert!(faults("ui/app.rs", "let d: egui_wgpu::Thing; let s = \"wgpu::Device\";").is_empty());
}
