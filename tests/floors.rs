//! The house's floors: imports go down only, neighbours on a floor do not import each other, and each outside library stays
//! on its own floor.

use crate::common::sources;
use std::path::PathBuf;

/// Ground to roof; modules of one entry are neighbours.
const FLOORS: &[&[&str]] = &[
    &["math"],
    &["volume"],
    &["mesh"],
    &["io", "paint", "segment", "explode", "annotate"],
    &["gpu"],
    &["document"],
    &["interact"],
    &["script", "ui"],
    &["main"],
];

/// Where a library may be named, as a prefix of the path below `src`.
const LIBRARIES: &[(&str, &[&str])] = &[
    ("wgpu", &["gpu/", "ui/window/canvas"]),
    ("naga", &["gpu/"]),
    ("naga_oil", &["gpu/"]),
    ("egui", &["ui/"]),
    ("eframe", &["ui/"]),
    ("rapier3d", &["explode/bodies"]),
    ("zarrs", &["document/"]),
    ("base64", &["document/"]),
    ("harfrust", &["annotate/picture/"]),
    ("skrifa", &["annotate/picture/", "io/system_fonts"]),
    ("spade", &["annotate/window/"]),
];

/// Folders and files inside a floor, ground to roof, as [`FLOORS`]: a file names only what stands below its own folder. `mod` is
/// what the floor's own `mod.rs` defines; that file and what the whole floor is seen by (its re-exports) may name all.
const INNER: &[(&str, &[&[&str]])] = &[
    (
        "io",
        &[
            &["disk", "progress", "regular", "system_fonts", "words"],
            &["error"],
            &["codec", "place", "replace", "statistics"],
            &["head", "layout", "colour"],
            &["leaving", "raw", "stream", "reader"],
            &["layout_read"],
            &["formats", "meshes"],
            &["export", "export_mesh", "foreign"],
            &["open"],
            &["info"],
        ],
    ),
    (
        "gpu",
        &[&["device"], &["picture"], &["fields"], &["layers"], &["brush", "cast"], &["trace"], &["slice", "backdrop"]],
    ),
    (
        "document",
        &[
            &["disk", "watch"],
            &["error"],
            &["scene"],
            &["state"],
            &["subject", "command"],
            &["history"],
            &["project", "reduce"],
            &["journal", "paths", "look_rows", "spared"],
            &["frame", "family"],
            &["live"],
            &["mod"],
            &["place"],
            &["apply"],
        ],
    ),
    (
        "interact",
        &[
            &["boxes", "event", "readout"],
            &["writing"],
            &["curve", "footprint", "mark", "projection", "surface", "brush", "slices", "context"],
            &["aim", "gesture", "devices"],
            &["click", "looking", "written"],
            &["tools"],
            &["machine", "preview"],
            &["keys"],
        ],
    ),
    ("ui", &[&["style", "browse"], &["thread"], &["state"], &["window"], &["views"], &["panels", "dialogs"]]),
];

/// Floors of which no file may be reached from itself along imports.
const WITHOUT_CIRCLES: &[&str] = &[
    "math", "volume", "annotate", "io", "paint", "segment", "mesh", "explode", "gpu", "document", "interact", "script",
    "ui",
];

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

/// The same with every path from a parent said from the crate's root.
fn from_root(path: &str, code: &str) -> String {
    let own = module_of(path);
    let mut out = String::new();
    let mut rest = code;
    while let Some(at) = rest.find("super::") {
        let (before, mut after) = rest.split_at(at);
        out.push_str(before);
        let mut depth = 0;
        while let Some(next) = after.strip_prefix("super::") {
            (after, depth) = (next, depth + 1);
        }
        let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let parent = &own[..own.len().saturating_sub(depth)];
        match before.ends_with(word) {
            true => out.push_str("super::"),
            false => ["crate"].iter().chain(parent).for_each(|part| out.push_str(&format!("{part}::"))),
        }
        rest = after;
    }
    out + rest
}

/// Every path from the crate's root that a file names, grouped imports taken apart: `crate::a::{b, c::D}` is `a b` and `a c D`.
fn named_paths(code: &str) -> Vec<Vec<String>> {
    fn tree(text: &[char], at: &mut usize, before: &[String], found: &mut Vec<Vec<String>>) {
        let mut path = before.to_vec();
        let mut word = String::new();
        while let Some(&c) = text.get(*at) {
            if c.is_alphanumeric() || c == '_' {
                word.push(c);
                *at += 1;
                continue;
            }
            if !word.is_empty() {
                path.push(std::mem::take(&mut word));
            }
            if text[*at..].starts_with(&[':', ':']) {
                *at += 2;
            } else if c == '{' && text[..*at].ends_with(&[':', ':']) {
                *at += 1;
                while text.get(*at).is_some_and(|&c| c != '}') {
                    while text.get(*at).is_some_and(|c| c.is_whitespace() || *c == ',') {
                        *at += 1;
                    }
                    if text.get(*at).is_some_and(|&c| c != '}') {
                        tree(text, at, &path, found);
                        // A name's alias, or a glob's star.
                        while text.get(*at).is_some_and(|&c| c != ',' && c != '}') {
                            *at += 1;
                        }
                    }
                }
                *at += 1;
                return;
            } else {
                break;
            }
        }
        if !word.is_empty() {
            path.push(word);
        }
        found.push(path);
    }
    let mut found = Vec::new();
    for root in ["crate::", "burin::"] {
        for (at, _) in code.match_indices(root) {
            if !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$' || c == ':') {
                let text: Vec<char> = code[at + root.len() - 2..].chars().collect();
                tree(&text, &mut 0, &[], &mut found);
            }
        }
    }
    found
}

/// A file's place among the modules: `gpu/fields/pool.rs` is `gpu fields pool`, as is `gpu/fields/pool/mod.rs`.
fn module_of(path: &str) -> Vec<&str> {
    path.trim_end_matches(".rs").trim_end_matches("/mod").split('/').collect()
}

/// Which folder of its floor a path leads into, as [`INNER`] names it; a type or function of the floor itself is of `mod`.
fn folder_in<'a>(order: &[&[&'a str]], path: &[&str]) -> Option<&'a str> {
    let name = path.get(1)?;
    order.iter().flat_map(|row| row.iter()).find(|f| *f == name).copied().or(Some("mod"))
}

/// What is wrong with a file's imports inside its own floor.
fn inner_faults(path: &str, code: &str) -> Vec<String> {
    let own = module_of(path);
    let Some((floor, order)) = INNER.iter().find(|(floor, _)| *floor == own[0]) else { return Vec::new() };
    let height = |folder: &str| order.iter().position(|row| row.contains(&folder));
    let mut faults = Vec::new();
    let Some(&folder) = own.get(1) else { return faults };
    let Some(height_of_own) = height(folder) else {
        return vec![format!("{path}: {folder} has no place in the order of {floor}")];
    };
    for named in named_paths(code) {
        let named: Vec<&str> = named.iter().map(String::as_str).collect();
        if named.first() != Some(floor) {
            continue;
        }
        let other = folder_in(order, &named).unwrap_or("mod");
        if other == "mod" && height("mod").is_none() {
            faults.push(format!("{path} names {} through the floor's door", named.join("::")));
        } else if other != folder && height(other).is_none_or(|h| h >= height_of_own) {
            faults.push(format!("{path} imports {}, which does not stand below {folder}", named.join("::")));
        }
    }
    let parent = own[..own.len() - 1].iter().map(|part| format!("{part}::")).collect::<String>();
    if code.contains(&format!("use crate::{parent}*")) {
        faults.push(format!("{path} takes all that its parent has"));
    }
    faults.dedup();
    faults
}

/// Files of a floor that import each other in a circle, each circle once. A module and what lies in its own folder are one.
fn circles(files: &[(String, String)]) -> Vec<Vec<String>> {
    let modules: Vec<Vec<&str>> = files.iter().map(|(path, _)| module_of(path)).collect();
    let names: Vec<Vec<usize>> = files
        .iter()
        .zip(&modules)
        .map(|((path, text), own)| {
            let named = named_paths(&from_root(path, &code(text)));
            let files = named.iter().filter_map(|path| {
                // The longest beginning of the path that is a file.
                let is_at =
                    |n: usize| modules.iter().position(|m| m.len() == n && m.iter().zip(path).all(|(a, b)| a == b));
                (1..=path.len()).rev().find_map(is_at)
            });
            files.filter(|&at| !own.starts_with(&modules[at]) && !modules[at].starts_with(own)).collect()
        })
        .collect();
    let reached = |from: usize| {
        let (mut seen, mut open) = (vec![false; files.len()], names[from].clone());
        while let Some(at) = open.pop() {
            if !std::mem::replace(&mut seen[at], true) {
                open.extend(&names[at]);
            }
        }
        seen
    };
    let reach: Vec<Vec<bool>> = (0..files.len()).map(reached).collect();
    let mut found: Vec<Vec<String>> = Vec::new();
    for (at, reached) in reach.iter().enumerate() {
        let circle: Vec<usize> = (0..files.len()).filter(|&b| reached[b] && reach[b][at]).collect();
        if circle.first() == Some(&at) {
            found.push(circle.iter().map(|&b| files[b].0.clone()).collect());
        }
    }
    found
}

/// What is wrong with a file, in sentences.
fn faults(path: &str, text: &str) -> Vec<String> {
    let code = from_root(path, &code(text));
    let module = path.split(['/', '.']).next().unwrap_or("");
    let mut faults = Vec::new();
    if let Some(own) = floor_of(module) {
        for named in named_paths(&code) {
            if let Some(name) = named.first()
                && let Some(other) = floor_of(name)
                && name != module
                && other >= own
            {
                faults.push(format!("{path} imports {name}, which is not on a floor below"));
            }
        }
        faults.extend(inner_faults(path, &code));
    } else if module != "lib" {
        faults.push(format!("{path}: module {module} has no floor"));
    }
    for (library, places) in LIBRARIES {
        let names = |c: &str| {
            c.match_indices(&format!("{library}::"))
                .any(|(i, _)| !c[..i].ends_with(|b: char| b.is_alphanumeric() || b == '_' || b == ':'))
                || c.contains(&format!("use {library};"))
                || c.contains(&format!("use {library} as"))
        };
        if names(&code) && !places.iter().any(|p| path.starts_with(p)) {
            faults.push(format!("{path} names {library}, which belongs in {places:?}"));
        }
    }
    faults.dedup();
    faults
}

/// All files of the program, by their path below `src`.
fn program() -> Vec<(String, String)> {
    let root = crate::common::root().join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    assert!(files.len() > 20, "sources not found");
    let named = |f: &PathBuf| f.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    files.iter().map(|f| (named(f), std::fs::read_to_string(f).unwrap())).collect()
}

#[test]
fn imports_go_down_only_and_libraries_stay_on_their_floor() {
    let found: Vec<String> = program().iter().flat_map(|(path, text)| faults(path, text)).collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn no_file_imports_itself_in_a_circle() {
    let program = program();
    for floor in WITHOUT_CIRCLES {
        let files: Vec<(String, String)> =
            program.iter().filter(|(path, _)| path.starts_with(&format!("{floor}/"))).cloned().collect();
        assert!(!files.is_empty(), "{floor} not found");
        let found = circles(&files);
        assert!(found.is_empty(), "{found:#?}");
    }
}

#[test]
fn a_circle_is_found() {
    let file = |path: &str, text: &str| (path.to_owned(), text.to_owned());
    let circle = [
        file("gpu/mod.rs", "pub use cast::tiles::Tiles;"),
        file("gpu/cast/tiles.rs", "use crate::gpu::{device::Gpu, cast::order::Order as Row};"),
        file("gpu/cast/order.rs", "use crate::gpu::cast::solid::{Solid};"),
        file("gpu/cast/solid.rs", "fn f() { crate::gpu::cast::tiles::list(); }"),
        file("gpu/device/mod.rs", "// crate::gpu::cast::tiles"),
    ];
    assert_eq!(circles(&circle), [["gpu/cast/tiles.rs", "gpu/cast/order.rs", "gpu/cast/solid.rs"]]);
    assert!(circles(&circle[..3]).is_empty());
    // A folder's own file may name what lies in it, and be named there.
    let folder = [
        file("gpu/pool/mod.rs", "use crate::gpu::pool::pages::Page;"),
        file("gpu/pool/pages.rs", "use crate::gpu::pool::Pool;"),
    ];
    assert!(circles(&folder).is_empty());
}

#[test]
fn a_forbidden_import_is_found() {
    let up = "use crate::{math::Ray,\n    gpu::{Gpu, Caster}};";
    assert_eq!(faults("paint/dab.rs", up).len(), 1);
    assert_eq!(faults("paint/dab.rs", "fn f() { crate::explode::split(); }").len(), 1);
    assert_eq!(faults("document/mod.rs", "use wgpu::Device;").len(), 1);
    assert_eq!(faults("ui/window/app.rs", "let d: wgpu::Device;").len(), 1);
    assert_eq!(faults("annex/mod.rs", "").len(), 1);
    assert!(faults("gpu/fields/pool.rs", "use crate::volume::Field; use wgpu::Device; // crate::ui").is_empty());
    assert!(faults("ui/window/app.rs", "let d: egui_wgpu::Thing; let s = \"wgpu::Device\";").is_empty());
    assert_eq!(faults("document/mod.rs", "use wgpu as graphics;").len(), 1);
    assert_eq!(faults("paint/dab.rs", "use super::super::gpu::Gpu;").len(), 1);
    // Inside a floor.
    assert_eq!(faults("gpu/fields/pool.rs", "use super::super::cast::tiles::Tiles;").len(), 1);
    assert_eq!(faults("gpu/device/mod.rs", "use super::cast::tiles::Tiles;").len(), 1);
    assert!(faults("gpu/fields/pool.rs", "use super::super::device::Gpu; pub(super) fn f() {}").is_empty());
    assert_eq!(faults("ui/window/app.rs", "use crate::ui::dialogs::what::What;").len(), 1);
    assert_eq!(faults("gpu/fields/pool.rs", "use crate::gpu::cast::tiles::Tiles;").len(), 1);
    assert_eq!(faults("gpu/cast/tiles.rs", "use crate::gpu::{device::Gpu, brush::painter::Painter};").len(), 1);
    assert_eq!(faults("gpu/cast/tiles.rs", "use crate::gpu::Painter;").len(), 1);
    assert_eq!(faults("gpu/annex/tiles.rs", "").len(), 1);
    assert_eq!(faults("document/scene/check.rs", "fn f() { crate::document::apply::view::near() }").len(), 1);
    assert_eq!(faults("document/live/motion.rs", "use crate::document::Document;").len(), 1);
    assert_eq!(faults("document/apply/mod.rs", "use super::*;").len(), 1);
    assert_eq!(faults("interact/event.rs", "use crate::interact::tools::Tool;").len(), 1);
    assert_eq!(faults("interact/tools/brush.rs", "use crate::interact::machine::Interaction;").len(), 1);
    assert_eq!(faults("io/codec/inflate.rs", "use crate::io::formats::readers;").len(), 1);
    assert_eq!(faults("io/formats/nrrd/mod.rs", "fn f() { crate::io::open::open(p) }").len(), 1);
    assert!(faults("document/apply/ask.rs", "use crate::document::{Document, frame::WHOLE};").is_empty());
    assert!(faults("gpu/mod.rs", "pub use cast::tiles::Tiles; use crate::gpu::slice::Slice;").is_empty());
    assert!(
        faults("gpu/cast/tiles.rs", "use crate::gpu::cast::order::{self, Order}; use crate::gpu::fields::pool::Pool;")
            .is_empty()
    );
}

#[test]
fn documentation_says_what_a_thing_is_instead_of_where_that_is_said() {
    for (path, text) in program() {
        for empty in ["See the module", "see the module", "module's head", "See the head"] {
            assert!(!text.contains(empty), "{path}: {empty:?} tells a reader of the documentation nothing");
        }
    }
}
