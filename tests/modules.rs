//! Every file of the program, its tests and its benches is compiled: a module that nobody names holds nothing and fails never.

use crate::common::sources;
use std::path::{Path, PathBuf};

/// The files below a folder that no file where their module would be declared names, as a module or as a tool of the list of tools.
/// `build.rs` lists formats of files.
fn unnamed(root: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    sources(root, &mut files);
    files.retain(|file| {
        let (Some(folder), Some(stem)) = (file.parent(), file.file_stem().and_then(|s| s.to_str())) else {
            return true;
        };
        // A folder's own file is named as its folder is.
        let (folder, name) = match stem {
            "main" | "lib" => return false,
            "mod" if folder == root => return false,
            "mod" => (folder.parent().unwrap(), folder.file_name().unwrap().to_str().unwrap()),
            _ => (folder, stem),
        };
        let by = ["mod.rs", "main.rs", "lib.rs"].map(|own| folder.join(own)).into_iter();
        let mut by = by.chain([folder.with_extension("rs")]).filter_map(|file| std::fs::read_to_string(file).ok());
        !folder.ends_with("io/formats")
            && !by.any(|text| ["mod {};", " in {},"].iter().any(|way| text.contains(&way.replace("{}", name))))
    });
    files
}

#[test]
fn every_file_is_a_module_that_somebody_names() {
    let root = crate::common::root();
    for folder in ["src", "tests", "benches/operations"] {
        assert_eq!(
            unnamed(&root.join(folder)),
            [] as [PathBuf; 0],
            "name them where their folder's modules are listed"
        );
    }
}

#[test]
fn a_file_that_nobody_names_is_found() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    };
    write("main.rs", "mod named;\nmod folder;\nmod with;\n");
    write("named.rs", "");
    write("folder/mod.rs", "mod inner;\n");
    write("folder/inner.rs", "");
    write("with.rs", "mod deep;\n");
    write("with/deep.rs", "");
    assert_eq!(unnamed(dir.path()), [] as [PathBuf; 0]);
    let mut lost =
        vec![write("lost.rs", ""), write("folder/lost.rs", ""), write("gone/mod.rs", ""), write("with/x.rs", "")];
    let mut found = unnamed(dir.path());
    lost.sort();
    found.sort();
    assert_eq!(found, lost);
}
