//! Files and folders that Burin does not read, by what they are: DICOM, pictures, archives, meshes, other volumes.
//!
//! Whoever drops one of them is told what it is and what to do, not that some bytes were not expected. Looks at first bytes, never
//! at all of a file, and at no more than some hundred files of a folder.

use crate::io::error::IoError;
use crate::io::formats::readers;
use crate::io::head::{HEAD_BYTES, head};
use crate::io::regular;
use std::path::Path;

/// What something is, and what to do with it.
#[derive(Debug, PartialEq, Eq)]
struct Kind {
    what: &'static str,
    /// What to do; the formats that are read are told behind it where it ends in a colon.
    advice: &'static str,
}

const DICOM: &str =
    "its reader comes later; until then convert the series to NIfTI or NRRD, with dcm2niix or 3D Slicer";
const VOLUME: &str =
    "its reader comes later; until then convert it to NIfTI or NRRD, with 3D Slicer or ITK-SNAP; Burin opens:";
const PICTURE: &str =
    "one picture is no volume; make one NRRD of a stack of them, with Fiji or 3D Slicer; Burin opens:";
const MESH: &str = "a surface has no voxels; Burin opens volumes:";
const ARCHIVE: &str = "unpack it and open what is in it; Burin opens:";
const OTHER: &str = "it holds no volume that Burin knows; Burin opens:";

/// Beginnings of files: where, which bytes, what they are.
const BEGINNINGS: [(usize, &[u8], &str, &str); 40] = [
    (128, b"DICM", "a DICOM file", DICOM),
    (0, b"\x89PNG\r\n\x1a\n", "a PNG picture", PICTURE),
    (0, b"\xff\xd8\xff", "a JPEG picture", PICTURE),
    (0, b"\0\0\0\x0cjP  ", "a JPEG 2000 picture", PICTURE),
    (0, b"II*\0", "a TIFF picture", PICTURE),
    (0, b"MM\0*", "a TIFF picture", PICTURE),
    (0, b"II+\0", "a BigTIFF picture", PICTURE),
    (0, b"MM\0+", "a BigTIFF picture", PICTURE),
    (0, b"GIF8", "a GIF picture", PICTURE),
    (8, b"WEBP", "a WebP picture", PICTURE),
    (0, b"v/1\x01", "an OpenEXR picture", PICTURE),
    (0, b"PK\x03\x04", "a ZIP archive", ARCHIVE),
    (0, b"PK\x05\x06", "an empty ZIP archive", ARCHIVE),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive", ARCHIVE),
    (0, b"Rar!\x1a\x07", "a RAR archive", ARCHIVE),
    (257, b"ustar", "a TAR archive", ARCHIVE),
    (0, b"\xfd7zXZ\0", "a file compressed with xz", ARCHIVE),
    (0, b"\x28\xb5\x2f\xfd", "a file compressed with Zstandard", ARCHIVE),
    (0, b"BZh", "a file compressed with bzip2", ARCHIVE),
    (0, b"\x1f\x8b", "a file compressed with gzip twice", "unpack it once (gunzip) and open the result"),
    (0, b"ObjectType =", "a MetaImage volume (.mha, .mhd)", VOLUME),
    (0, b"ObjectType=", "a MetaImage volume (.mha, .mhd)", VOLUME),
    (0, b"NDims =", "a MetaImage volume (.mha, .mhd)", VOLUME),
    (0, b"# vtk DataFile", "a VTK file", VOLUME),
    (0, b"<VTKFile", "a VTK file", VOLUME),
    (0, b"<?xml version=\"1.0\"?>\n<VTKFile", "a VTK file", VOLUME),
    (0, b"\x89HDF\r\n\x1a\n", "an HDF5 file (MINC 2, Imaris, Matlab and others)", VOLUME),
    (0, b"CDF\x01", "a NetCDF file (MINC 1 and others)", VOLUME),
    (0, b"\0\0\0\x01\0\0", "an MGH volume of FreeSurfer", VOLUME),
    (0, b"\x93NUMPY", "a NumPy array", VOLUME),
    (0, b"MATLAB 5.0", "a Matlab file", VOLUME),
    (0, b"ply\n", "a PLY surface mesh", MESH),
    (0, b"ply\r\n", "a PLY surface mesh", MESH),
    (0, b"glTF", "a glTF scene of meshes", MESH),
    (0, b"solid ", "an STL surface mesh", MESH),
    (0, b"%PDF", "a PDF document", OTHER),
    (0, b"<!DOCTYPE html", "a web page, not the file that was to be downloaded", "get the file again"),
    (0, b"<!doctype html", "a web page, not the file that was to be downloaded", "get the file again"),
    (0, b"<html", "a web page, not the file that was to be downloaded", "get the file again"),
    (0, b"version https://git-lfs", "a pointer of Git LFS, not the file itself", "fetch the file with git lfs pull"),
];

/// Endings of files whose beginnings say nothing.
const ENDINGS: [(&str, &str, &str); 5] = [
    (".obj", "an OBJ surface mesh", MESH),
    (".gltf", "a glTF scene of meshes", MESH),
    (".bmp", "a BMP picture", PICTURE),
    (".czi", "a Zeiss microscope volume", VOLUME),
    (
        ".raw",
        "numbers without a header",
        "write a NRRD header beside it (.nhdr) that says their type and sizes, and open that",
    ),
];

/// Value representations of explicit DICOM.
const REPRESENTATIONS: &[u8] =
    b"AE AS AT CS DA DS DT FL FD IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN UR US UT UV ";

/// Files of a folder, and of the folders in it, that are looked at.
const LOOKED_AT: usize = 300;
/// How deep.
const DEEP: usize = 4;

/// The error that names what a file is; `None` if nobody knows. `head` are its first bytes, inflated if it is gzip, `len` its length.
pub(super) fn file(path: &Path, head: &[u8], len: u64) -> Option<IoError> {
    let kind = kind(path, head, len)?;
    Some(said(path, kind.what.into(), kind.advice))
}

/// The error that names what a folder is.
pub(super) fn folder(path: &Path) -> IoError {
    let (what, advice) = describe_folder(path);
    said(path, what, advice)
}

/// What something that is no project is, in a sentence: `this is a folder with …; what to do`.
pub fn what_is(path: &Path) -> String {
    let (what, advice) = match std::fs::metadata(path) {
        Ok(about) if about.is_dir() => describe_folder(path),
        Ok(about) => {
            let head = head(path).unwrap_or_default();
            match kind(path, &head, about.len()) {
                Some(Kind { what, advice }) => (what.to_owned(), advice),
                None => (
                    "a file, where a project is a folder".into(),
                    "open it as a volume, or choose the project's folder",
                ),
            }
        }
        Err(_) => return "there is nothing of this name; choose the folder of a project".into(),
    };
    format!("this is {what}; {}", complete(advice))
}

fn said(path: &Path, what: String, advice: &str) -> IoError {
    IoError::Foreign { file: path.display().to_string(), what, advice: complete(advice) }
}

fn complete(advice: &str) -> String {
    match advice.strip_suffix(':') {
        Some(_) => format!("{advice} {}", readers().iter().map(|r| r.name()).collect::<Vec<_>>().join(", ")),
        None => advice.into(),
    }
}

fn kind(path: &Path, head: &[u8], len: u64) -> Option<Kind> {
    if len == 0 {
        return Some(Kind { what: "an empty file (0 bytes)", advice: "get the file again" });
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    if name == "dicomdir" {
        return Some(Kind { what: "a DICOMDIR, the list of what is on a DICOM medium", advice: DICOM });
    }
    if name == "project.json" || name == "generation.json" {
        return Some(Kind { what: "a file of a Burin project", advice: "open the project's folder" });
    }
    let begins = |(at, bytes, ..): &&(usize, &[u8], _, _)| head.get(*at..at + bytes.len()) == Some(*bytes);
    if let Some(&(_, _, what, advice)) = BEGINNINGS.iter().find(begins) {
        return Some(Kind { what, advice });
    }
    if is_bare_dicom(head, len) {
        return Some(Kind { what: "a DICOM file (without the usual preamble)", advice: DICOM });
    }
    // 80 bytes of anything, the number of triangles, 50 bytes each.
    let triangles = head.get(80..84).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if triangles.is_some_and(|n| n > 0 && 84 + 50 * u64::from(n) == len) {
        return Some(Kind { what: "an STL surface mesh", advice: MESH });
    }
    if let Some(&(_, what, advice)) = ENDINGS.iter().find(|(ending, ..)| name.ends_with(ending)) {
        return Some(Kind { what, advice });
    }
    [".dcm", ".ima"]
        .iter()
        .any(|e| name.ends_with(e))
        .then_some(Kind { what: "a DICOM file by its name, though it does not begin like one", advice: DICOM })
}

/// Whether a file is a DICOM data set without preamble: elements of group 2 or 8 on, each behind the last, in one of the three
/// plain transfer syntaxes (PS3.5, 7.1).
fn is_bare_dicom(head: &[u8], len: u64) -> bool {
    [(false, true), (false, false), (true, true)]
        .into_iter()
        .any(|(big, explicit)| elements(head, len, big, explicit) >= 3)
}

/// How many elements follow one another from the beginning on.
fn elements(head: &[u8], len: u64, big: bool, explicit: bool) -> usize {
    let number = |bytes: &[u8]| -> u64 {
        let digits = bytes.iter().map(|&b| u64::from(b));
        if big { digits.fold(0, |n, b| n << 8 | b) } else { digits.rev().fold(0, |n, b| n << 8 | b) }
    };
    let (mut at, mut count, mut last) = (0_usize, 0, 0);
    while let Some(element) = head.get(at..at + 8) {
        let tag = number(&element[..2]) << 16 | number(&element[2..4]);
        let first = count > 0 || matches!(tag >> 16, 2 | 8);
        let representation = &element[4..6];
        let (value_at, length) = if !explicit {
            (at + 8, number(&element[4..8]))
        } else if !REPRESENTATIONS.chunks(3).any(|r| &r[..2] == representation) {
            return if count > 0 { 0 } else { count };
        } else if [b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT", b"UV"]
            .iter()
            .any(|long| &long[..] == representation)
        {
            let Some(length) = head.get(at + 8..at + 12) else { return count };
            (at + 12, number(length))
        } else {
            (at + 8, number(&element[6..8]))
        };
        // Sequences may leave their length open; what is in them is not looked at.
        if length == 0xffff_ffff && count > 0 {
            return count + 1;
        }
        if !first || (count > 0 && tag <= last) || length % 2 == 1 || value_at as u64 + length > len {
            return 0;
        }
        (last, count) = (tag, count + 1);
        at = value_at + length as usize;
    }
    count
}

/// What is in a folder.
#[derive(Default)]
struct Contents {
    looked_at: usize,
    dicom: usize,
    pictures: usize,
    picture: &'static str,
    volumes: Vec<String>,
    others: usize,
}

fn describe_folder(path: &Path) -> (String, &'static str) {
    let has = |name: &str| path.join(name).symlink_metadata().is_ok();
    if has("project.json") {
        return ("a folder with a project".into(), "open it as a project");
    }
    if [".zarray", ".zgroup", ".zattrs", "zarr.json"].into_iter().any(has) {
        return ("a Zarr volume".into(), VOLUME);
    }
    let mut found = Contents::default();
    look(path, &mut found, 0);
    let many = |n: usize, what: &str| match n {
        1 => format!("one {what}"),
        n if found.looked_at >= LOOKED_AT => format!("{n} {what}s or more"),
        n => format!("{n} {what}s"),
    };
    match found {
        Contents { dicom, .. } if dicom > 0 || has("DICOMDIR") => {
            let of = if dicom > 0 { format!(" ({})", many(dicom, "DICOM file")) } else { String::new() };
            (format!("a folder with a DICOM series{of}"), DICOM)
        }
        Contents { ref volumes, .. } if !volumes.is_empty() => {
            let names = volumes.iter().take(3).cloned().collect::<Vec<_>>().join(", ");
            let more = if volumes.len() > 3 { ", …" } else { "" };
            (format!("a folder with {} ({names}{more})", many(volumes.len(), "volume file")), "open one of them")
        }
        Contents { pictures, picture, .. } if pictures > 0 => {
            let what = picture.trim_start_matches("an ").trim_start_matches("a ");
            (format!("a folder with {}", many(pictures, what)), STACK)
        }
        Contents { others: 0, .. } => ("a folder with nothing in it".into(), FOLDER),
        _ => ("a folder without a volume or a project".into(), FOLDER),
    }
}

const STACK: &str =
    "a reader of stacks comes later; until then make one NRRD of them, with Fiji or 3D Slicer; Burin opens:";
const FOLDER: &str = "open the folder of a project, or a volume file:";

fn look(path: &Path, found: &mut Contents, depth: usize) {
    let Ok(entries) = std::fs::read_dir(path) else { return };
    let mut entries: Vec<_> = entries.flatten().take(10 * LOOKED_AT).map(|e| (e.path(), e.file_type())).collect();
    entries.sort_by(|a, b| a.0.cmp(&b.0));
    for (path, kind_of_entry) in entries {
        if found.looked_at >= LOOKED_AT {
            return;
        }
        // Links to folders may lead in circles.
        if kind_of_entry.is_ok_and(|t| t.is_dir()) {
            found.others += 1;
            if depth < DEEP {
                look(&path, found, depth + 1);
            }
            continue;
        }
        let is_file = std::fs::metadata(&path).is_ok_and(|m| regular::must_be_regular(&m).is_ok());
        let Some(head) = is_file.then(|| head(&path).ok()).flatten() else { continue };
        found.looked_at += 1;
        found.others += 1;
        if readers().iter().any(|r| r.recognises(&head)) {
            found.volumes.push(crate::io::error::shown(&path.file_name().unwrap_or_default().to_string_lossy()));
            continue;
        }
        let len = std::fs::metadata(&path).map_or(HEAD_BYTES, |m| m.len());
        match kind(&path, &head, len) {
            Some(Kind { advice: DICOM, .. }) => found.dicom += 1,
            Some(Kind { what, advice: PICTURE }) => {
                found.pictures += 1;
                found.picture = what;
            }
            _ => {}
        }
    }
}
