//! Lists the formats of volume files: whatever lies in `src/io/formats` is one, so that a new format is its own file and no line
//! elsewhere. `src/io/formats/mod.rs` includes the list and says what a format's file must have.

use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?);
    let folder = root.join("src/io/formats");
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut formats = std::fs::read_dir(&folder)?
        .map(|entry| Ok(file_of(&entry?.path())))
        .filter_map(Result::transpose)
        .collect::<std::io::Result<Vec<_>>>()?;
    formats.sort();
    let mut list = String::new();
    for (name, file) in &formats {
        list += &format!("#[path = {file:?}]\nmod {name};\n");
    }
    let all: Vec<String> = formats.iter().map(|(name, _)| format!("&{name}::FORMAT")).collect();
    list += &format!("static FORMATS: [&FileFormat; {}] = [{}];\n", all.len(), all.join(", "));
    std::fs::write(PathBuf::from(std::env::var("OUT_DIR")?).join("formats.rs"), list)?;
    Ok(())
}

/// A format's name and its file, which is `name.rs` or `name/mod.rs`; `None` for what is no format.
fn file_of(path: &Path) -> Option<(String, PathBuf)> {
    let file = if path.is_dir() { path.join("mod.rs") } else { path.to_path_buf() };
    let name = path.file_stem()?.to_str()?.to_owned();
    (file.is_file() && file.extension()? == "rs" && name != "mod").then_some((name, file))
}
