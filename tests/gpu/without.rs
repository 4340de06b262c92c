//! Without a GPU the tests that need one fail and say what to install, unless `BURIN_WITHOUT_GPU=1` says that this is known.

use std::path::{Path, PathBuf};

/// Of each way by which tests come to a device: common, a made document, a file, the program, the window.
#[cfg(target_os = "linux")]
const THEY_NEED_ONE: [&str; 6] = [
    "document::brushes::the_same_stroke_paints_the_same_voxels_whatever_the_unit",
    "document::first_look::one_value_alone_is_seen_in_3d_and_in_slices",
    "document::program::a_picture_lies_on_the_background_that_is_asked_for",
    "document::strokes::a_stroke_whose_device_and_source_were_lost_can_be_cancelled",
    "gpu::device::no_memory_and_bad_calls_are_answers_and_the_device_goes_on",
    "ui::painted::pictures_lie_under_their_marks_and_panels_on_their_ground",
];

#[cfg(target_os = "linux")]
#[test]
fn without_a_gpu_the_tests_that_need_one_fail_unless_that_is_known() {
    let run = |known: Option<&str>| {
        let mut tests = std::process::Command::new(std::env::current_exe().unwrap());
        tests.arg("--exact").args(THEY_NEED_ONE).args(["--nocapture", "--test-threads", "1"]);
        // No driver is found there.
        tests.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        tests.env_remove("VK_ADD_DRIVER_FILES").env_remove("BURIN_WITHOUT_GPU").env("WGPU_BACKEND", "vulkan");
        tests.envs(known.map(|value| ("BURIN_WITHOUT_GPU", value)));
        let output = tests.output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.success(), String::from_utf8_lossy(&said).into_owned())
    };
    for known in [None, Some("0"), Some(""), Some("yes")] {
        let (success, said) = run(known);
        assert!(!success && said.contains("0 passed; 6 failed"), "{known:?}: {said}");
        assert_eq!(said.matches("mesa-vulkan-drivers); or set BURIN_WITHOUT_GPU=1").count(), 6, "{known:?}: {said}");
    }
    let (success, said) = run(Some("1"));
    assert!(success && said.contains("6 passed; 0 failed"), "{said}");
    assert_eq!(said.matches("skipped: ").count(), 6, "{said}");
}

fn files(dir: &Path, into: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()) {
        if path.is_dir() { files(&path, into) } else { into.push(path) }
    }
}

/// Carried to another machine, tests and benches read what lies beside them there.
#[test]
fn what_tests_and_benches_read_is_found_from_one_place() {
    let root = crate::common::root();
    let mut sources = Vec::new();
    files(&root.join("tests"), &mut sources);
    files(&root.join("benches"), &mut sources);
    let allowed = ["tests/common/mod.rs", "benches/operations/head.rs", "tests/gpu/without.rs"];
    for path in sources.iter().filter(|p| p.extension().is_some_and(|e| e == "rs")) {
        if allowed.iter().all(|own| !path.ends_with(own)) {
            let text = std::fs::read_to_string(path).unwrap();
            let found = ["CARGO_MANIFEST_DIR", "CARGO_BIN_EXE"].into_iter().find(|name| text.contains(name));
            assert_eq!(found, None, "{}: use common::root() and common::program()", path.display());
        }
    }
}

/// A test that asks in its own way whether there is a device is one that passes where there is none.
#[test]
fn one_place_decides_what_a_test_does_without_a_gpu_and_ci_never_says_that_it_is_known() {
    let root = crate::common::root();
    let mut tests = Vec::new();
    files(&root.join("tests"), &mut tests);
    let own = |path: &PathBuf| path.ends_with("common/gpu.rs") || path.ends_with("gpu/without.rs");
    let mut read = 0;
    for path in tests.iter().filter(|p| p.extension().is_some_and(|e| e == "rs") && !own(p)) {
        let text: String = std::fs::read_to_string(path).unwrap().split_whitespace().collect();
        assert!(!text.contains(".describe_gpu("), "{}: ask common::gpu::gpu()", path.display());
        for (at, call) in text.match_indices("Gpu::headless").chain(text.match_indices("create_render_state(")) {
            let rest = &text[at + call.len()..];
            let after = rest.split_once(')').map_or("", |(_, after)| after);
            let refuses = [".ok(", ".is_", ".map", ".and_then", ".unwrap_or", "else{"];
            let silent = refuses.iter().find(|r| after.starts_with(*r));
            assert_eq!(silent, None, "{}: ask common::gpu::gpu(), then unwrap", path.display());
        }
        read += 1;
    }
    assert!(read > 100, "{read}");
    let mut ci = Vec::new();
    files(&root.join(".ci"), &mut ci);
    ci.push(root.join("tools/test"));
    for path in ci {
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(!text.contains("BURIN_WITHOUT_GPU"), "{}", path.display());
    }
}
