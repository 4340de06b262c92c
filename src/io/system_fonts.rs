//! Finding fonts of the system for characters that the ones at hand lack.
//!
//! Walks the usual folders when it is asked, bounded in files and depth, and reads of each font only its table directory and its table of
//! characters. Owns that search. It opens files, so it lives above the modules that draw; they get the bytes.

use skrifa::raw::tables::cmap::Cmap;
use skrifa::raw::{FontData, FontRead};
use std::env;
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The most files that one search looks into.
const MAX_FILES: usize = 4_000;

/// How deep folders are walked.
const MAX_DEPTH: usize = 6;

/// The most fonts of a collection, tables of a font and bytes of a table of characters that are looked at.
const MAX_FONTS: u32 = 64;
const MAX_TABLES: u16 = 256;
const MAX_CMAP: u32 = 8 << 20;

/// The largest file that [`SystemFont::bytes`] reads.
const MAX_FILE: u64 = 128 << 20;

/// A font of the system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SystemFont {
    /// Its file.
    pub path: PathBuf,
    /// Its place in a collection, else 0.
    pub index: u32,
    /// Which of the wanted characters it is taken for.
    pub characters: Vec<char>,
}

impl SystemFont {
    /// The file's bytes.
    ///
    /// # Errors
    /// If it cannot be read, or is larger than 128 MiB.
    pub fn bytes(&self) -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        File::open(&self.path)?.take(MAX_FILE + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > MAX_FILE {
            return Err(std::io::Error::new(std::io::ErrorKind::FileTooLarge, "a font of at most 128 MiB expected"));
        }
        Ok(bytes)
    }
}

/// Where this system keeps fonts, the user's own ones first; not all need exist.
pub fn font_folders() -> Vec<PathBuf> {
    let home = env::var_os("HOME").map(PathBuf::from);
    let at_home = |inner: &str| home.as_ref().map(|h| h.join(inner));
    let windows = env::var_os("SystemRoot").map_or_else(|| PathBuf::from(r"C:\Windows"), PathBuf::from);
    let local = env::var_os("LOCALAPPDATA").map(|l| PathBuf::from(l).join(r"Microsoft\Windows\Fonts"));
    let folders: [Option<PathBuf>; 3] = if cfg!(windows) {
        [local, Some(windows.join("Fonts")), None]
    } else if cfg!(target_os = "macos") {
        [at_home("Library/Fonts"), Some("/Library/Fonts".into()), Some("/System/Library/Fonts".into())]
    } else {
        [at_home(".local/share/fonts"), Some("/usr/local/share/fonts".into()), Some("/usr/share/fonts".into())]
    };
    folders.into_iter().flatten().collect()
}

/// The least fonts of these folders that together have as many of the characters as any, at most `most`: each time the one that has most of
/// what is left, among equals an upright regular sans, then by path. Empty where nothing is wanted, without a look at the disk.
pub fn fonts_for(wanted: &[char], folders: &[PathBuf], most: usize) -> Vec<SystemFont> {
    if wanted.is_empty() || most == 0 {
        return Vec::new();
    }
    let mut files = Vec::new();
    for folder in folders {
        walk(folder, MAX_DEPTH, &mut files);
    }
    let mut found: Vec<SystemFont> = files.iter().flat_map(|path| fonts_of(path, wanted)).collect();
    let mut chosen = Vec::new();
    while chosen.len() < most {
        found.retain(|f| !f.characters.is_empty());
        let rank = |f: &SystemFont| (std::cmp::Reverse(f.characters.len()), oddness(&f.path), f.path.clone(), f.index);
        let Some(best) = found.iter().min_by_key(|f| rank(f)).cloned() else { break };
        found.iter_mut().for_each(|f| f.characters.retain(|c| !best.characters.contains(c)));
        chosen.push(best);
    }
    chosen
}

fn walk(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.take(4 * MAX_FILES).flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if files.len() >= MAX_FILES {
            return;
        }
        if path.is_dir() {
            if depth > 0 {
                walk(&path, depth - 1, files);
            }
        } else if is_font(&path) {
            files.push(path);
        }
    }
}

fn is_font(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    // A pipe of that name would never end.
    matches!(extension.as_deref(), Some("ttf" | "otf" | "ttc" | "otc")) && path.is_file()
}

/// How far a file's name is from that of a plain text face.
fn oddness(path: &Path) -> usize {
    let name = path.file_stem().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let odd = ["bold", "italic", "oblique", "light", "thin", "black", "mono", "condensed", "serif", "medium", "narrow"];
    2 * odd.iter().filter(|o| name.contains(*o)).count() + usize::from(!name.contains("regular"))
}

/// The fonts of one file that have any of the characters; none if it cannot be read.
fn fonts_of(path: &Path, wanted: &[char]) -> Vec<SystemFont> {
    let Ok(mut file) = File::open(path) else { return Vec::new() };
    let offsets = offsets(&mut file).unwrap_or_default();
    let font = |(index, offset): (usize, u32)| {
        let characters = has(&mut file, offset, wanted)?;
        (!characters.is_empty()).then(|| SystemFont { path: path.to_owned(), index: index as u32, characters })
    };
    offsets.into_iter().enumerate().filter_map(font).collect()
}

fn read(file: &mut File, at: u32, length: usize) -> Option<Vec<u8>> {
    file.seek(SeekFrom::Start(at.into())).ok()?;
    let mut bytes = Vec::new();
    file.take(length as u64).read_to_end(&mut bytes).ok()?;
    (bytes.len() == length).then_some(bytes)
}

fn number(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

/// Where the table directories of a file begin.
fn offsets(file: &mut File) -> Option<Vec<u32>> {
    let head = read(file, 0, 12)?;
    if head[..4] != *b"ttcf" {
        return Some(vec![0]);
    }
    let count = number(&head, 8)?.min(MAX_FONTS);
    let offsets = read(file, 12, 4 * count as usize)?;
    (0..count as usize).map(|n| number(&offsets, 4 * n)).collect()
}

/// Which of the characters a font has, if it has outlines.
fn has(file: &mut File, offset: u32, wanted: &[char]) -> Option<Vec<char>> {
    let count = u16::from_be_bytes(read(file, offset.checked_add(4)?, 2)?.try_into().ok()?).min(MAX_TABLES);
    let tables = read(file, offset.checked_add(12)?, 16 * usize::from(count))?;
    let named = |tag: &[u8; 4]| tables.chunks_exact(16).find(|t| t[..4] == *tag);
    [b"glyf", b"CFF ", b"CFF2"].into_iter().find_map(named)?;
    let record = named(b"cmap")?;
    let (at, length) = (number(record, 8)?, number(record, 12)?.min(MAX_CMAP));
    let bytes = read(file, at, length as usize)?;
    let cmap = Cmap::read(FontData::new(&bytes)).ok()?;
    Some(wanted.iter().copied().filter(|&c| cmap.map_codepoint(c).is_some_and(|g| g.to_u32() != 0)).collect())
}
