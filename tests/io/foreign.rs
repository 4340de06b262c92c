//! Files and folders that are not read are named for what they are, with what to do.

use super::files::*;
use burin::io;
use burin::volume::VoxelType;
use rand::Rng;
use std::path::Path;

fn said(path: &Path) -> String {
    let text = io::open(path).unwrap_err().to_string();
    assert!(text.starts_with(&path.display().to_string()), "{text}");
    assert_eq!(io::info(path, &|_| true).unwrap_err().to_string(), text);
    text
}

/// PS3.5: tag, for explicit ones a representation, length, value.
fn element(big: bool, explicit: bool, tag: (u16, u16), representation: &[u8; 2], value: &[u8]) -> Vec<u8> {
    let order = |bytes: &mut [u8]| {
        if big {
            bytes.reverse()
        }
    };
    let mut out = Vec::new();
    for half in [tag.0, tag.1] {
        let mut bytes = half.to_le_bytes();
        order(&mut bytes);
        out.extend_from_slice(&bytes);
    }
    let long = [b"OB", b"OW", b"SQ", b"UN", b"UT"].contains(&representation);
    if explicit {
        out.extend_from_slice(representation);
    }
    if explicit && !long {
        let mut bytes = (value.len() as u16).to_le_bytes();
        order(&mut bytes);
        out.extend_from_slice(&bytes);
    } else {
        if explicit {
            out.extend_from_slice(&[0, 0]);
        }
        let mut bytes = (value.len() as u32).to_le_bytes();
        order(&mut bytes);
        out.extend_from_slice(&bytes);
    }
    out.extend_from_slice(value);
    out
}

fn data_set(big: bool, explicit: bool) -> Vec<u8> {
    let of = |tag, representation, value: &[u8]| element(big, explicit, tag, representation, value);
    [
        of((8, 5), b"CS", b"ISO_IR 100"),
        of((8, 8), b"CS", b"ORIGINAL\\PRIMARY"),
        of((8, 0x16), b"UI", b"1.2.840.10008.5.1.4.1.1.4\0"),
        of((8, 0x60), b"CS", b"MR"),
        of((0x10, 0x10), b"PN", b"Somebody^Else "),
        of((0x28, 0x10), b"US", &[0, 1]),
        of((0x7fe0, 0x10), b"OW", &[7; 2000]),
    ]
    .concat()
}

fn part_10() -> Vec<u8> {
    let meta = element(false, true, (2, 0x10), b"UI", b"1.2.840.10008.1.2\0");
    [&[0; 128][..], b"DICM", &meta, &data_set(false, false)].concat()
}

#[test]
fn a_dicom_file_is_named_with_and_without_its_preamble_and_whatever_it_is_called() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.dcm", "a", "IM-0001-0002", "a.nii", "a.nrrd", "a.img"] {
        let text = said(&keep(&folder, name, &part_10()));
        assert!(text.contains("this is a DICOM file; its reader comes later") && text.contains("dcm2niix"), "{text}");
        for (big, explicit) in [(false, false), (false, true), (true, true)] {
            let text = said(&keep(&folder, name, &data_set(big, explicit)));
            assert!(text.contains("this is a DICOM file (without"), "{big} {explicit}: {text}");
        }
    }
    assert!(said(&keep(&folder, "a.dcm.gz", &gzip(&part_10()))).contains("a DICOM file"));
    assert!(said(&keep(&folder, "DICOMDIR", &part_10())).contains("DICOMDIR"));
    for name in ["odd.dcm", "odd.ima", "ODD.IMA"] {
        assert!(said(&keep(&folder, name, b"who knows")).contains("a DICOM file by its name"), "{name}");
    }
}

#[test]
fn nothing_else_is_taken_for_dicom() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = random(3);
    for round in 0..2000 {
        let mut bytes = vec![0; random.random_range(8..600)];
        random.fill(&mut bytes[..]);
        // Begins as one might, and goes on as none does.
        bytes[..4].copy_from_slice([[8, 0, 5, 0], [2, 0, 0, 0], [0, 8, 0, 5], [8, 0, 0, 0]][round % 4].as_slice());
        let text = said(&keep(&folder, "a.bin", &bytes));
        assert!(!text.contains("DICOM"), "{round}: {text}");
    }
    // A volume is a volume.
    let file = Nifti::new(VoxelType::U8, &[3, 4, 5], false).with(&noise(VoxelType::U8, 60, 1));
    assert!(io::open(keep(&folder, "a.dcm", &file)).is_ok());
}

#[test]
fn folders_are_named_by_what_is_in_them() {
    let outer = tempfile::tempdir().unwrap();
    let made = |names: &[(&str, Vec<u8>)]| {
        let folder = tempfile::tempdir_in(outer.path()).unwrap();
        for (name, bytes) in names {
            if let Some((inner, _)) = name.rsplit_once('/') {
                std::fs::create_dir_all(folder.path().join(inner)).unwrap();
            }
            keep(&folder, name, bytes);
        }
        let text = said(folder.path());
        // A project is asked for in other words, and answered in the same.
        let open = burin::document::Autosave::open(folder.path());
        assert_eq!(open.unwrap_err().to_string().split_once(": ").unwrap().1, text.split_once(": ").unwrap().1);
        assert!(!text.contains("is no project"), "{text}");
        text
    };
    let nifti = || Nifti::new(VoxelType::U8, &[1, 1, 1], false).with(&noise(VoxelType::U8, 1, 1));
    let png = || b"\x89PNG\r\n\x1a\n and more".to_vec();
    let text = made(&[("b.dcm", part_10()), ("a", data_set(false, true)), ("README", b"text".to_vec())]);
    assert!(text.contains("this is a folder with a DICOM series (2 DICOM files); its reader comes later"), "{text}");
    let text = made(&[("DICOMDIR", part_10()), ("DICOM/S1/S2/IM1", part_10()), ("v.nii", nifti())]);
    assert!(text.contains("a DICOM series (2 DICOM files)"), "{text}");
    let text = made(&[("a.nii.gz", gzip(&nifti())), ("sub/b.nii", nifti()), ("c.png", png())]);
    assert!(text.contains("this is a folder with 2 volume files (a.nii.gz, b.nii); open one of them"), "{text}");
    let text = made(&[("1.png", png()), ("2.png", png()), ("3.png", png())]);
    assert!(text.contains("this is a folder with 3 PNG pictures") && text.contains("stacks comes later"), "{text}");
    assert!(made(&[("a.zarr/.zarray", b"{}".to_vec()), ("zarr.json", b"{}".to_vec())]).contains("a Zarr volume"));
    assert!(made(&[]).contains("a folder with nothing in it"));
    assert!(
        made(&[("a.txt", b"text".to_vec())])
            .contains("a folder without a volume or a project; open the folder of a project")
    );
    let many: Vec<_> = (0..400).map(|n| (format!("{n:04}.dcm"), part_10())).collect();
    let many: Vec<_> = many.iter().map(|(name, bytes)| (name.as_str(), bytes.clone())).collect();
    assert!(made(&many).contains("300 DICOM files or more"));
    // No project there, and no folder either.
    for (name, bytes, found) in
        [("a.dcm", part_10(), "a DICOM file"), ("a.nii", nifti(), "a file, where a project is a folder")]
    {
        let text = burin::document::Autosave::open(&keep(&outer, name, &bytes)).unwrap_err().to_string();
        assert!(text.contains(&format!("{name}: this is {found}; ")), "{text}");
    }
    let text = burin::document::Autosave::open(&outer.path().join("nowhere")).unwrap_err().to_string();
    assert!(text.contains("nowhere: there is nothing of this name"), "{text}");
}

#[test]
fn other_files_that_people_drop_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let stl = |n: u32| [&[b' '; 80][..], &n.to_le_bytes(), &vec![0; 50 * n as usize]].concat();
    let tar = [&[b'a'; 257][..], b"ustar\0", &[0; 300]].concat();
    for (name, bytes, found, advice) in [
        ("a.png", b"\x89PNG\r\n\x1a\n".to_vec(), "a PNG picture", "NRRD"),
        ("a.jpg", b"\xff\xd8\xff\xe0..".to_vec(), "a JPEG picture", "NRRD"),
        ("a.tif", b"II*\0....".to_vec(), "a TIFF picture", "stack"),
        ("a.tiff", b"MM\0*....".to_vec(), "a TIFF picture", "stack"),
        ("a.zip", b"PK\x03\x04....".to_vec(), "a ZIP archive", "unpack it"),
        ("a.7z", b"7z\xbc\xaf\x27\x1c..".to_vec(), "a 7z archive", "unpack it"),
        ("a.tar", tar.clone(), "a TAR archive", "unpack it"),
        ("a.tgz", gzip(&tar), "a TAR archive", "unpack it"),
        ("a.nii.xz", b"\xfd7zXZ\0..".to_vec(), "compressed with xz", "unpack it"),
        ("a.nii.bz2", b"BZh9....".to_vec(), "compressed with bzip2", "unpack it"),
        ("a.mha", b"ObjectType = Image\nNDims = 3\n".to_vec(), "a MetaImage volume", "3D Slicer"),
        ("a.mhd", b"NDims = 3\n".to_vec(), "a MetaImage volume", "3D Slicer"),
        ("a.vti", b"<VTKFile type=\"ImageData\">".to_vec(), "a VTK file", "3D Slicer"),
        ("a.stl", b"solid thing\n".to_vec(), "an STL surface mesh", "no voxels"),
        ("b.stl", stl(3), "an STL surface mesh", "no voxels"),
        ("a.ply", b"ply\nformat ascii 1.0\n".to_vec(), "a PLY surface mesh", "no voxels"),
        ("a.obj", b"v 0 0 0\n".to_vec(), "an OBJ surface mesh", "no voxels"),
        ("a.glb", b"glTF\x02\0\0\0".to_vec(), "a glTF scene", "no voxels"),
        ("a.h5", b"\x89HDF\r\n\x1a\n".to_vec(), "an HDF5 file", "3D Slicer"),
        ("a.npy", b"\x93NUMPY\x01\0".to_vec(), "a NumPy array", "NRRD"),
        ("a.nii.gz", b"<!DOCTYPE html><html>".to_vec(), "a web page", "get the file again"),
        ("b.nii.gz", b"version https://git-lfs.github.com/spec/v1\n".to_vec(), "a pointer of Git LFS", "git lfs pull"),
        ("a.raw", vec![9; 700], "numbers without a header", ".nhdr"),
        ("project.json", b"{}".to_vec(), "a file of a Burin project", "folder"),
        ("empty.nii", vec![], "an empty file (0 bytes)", "get the file again"),
    ] {
        let text = said(&keep(&folder, name, &bytes));
        assert!(text.contains(": this is ") && text.contains(found) && text.contains(advice), "{text}");
    }
}

#[test]
fn a_nifti_that_was_compressed_twice_is_named_so() {
    let folder = tempfile::tempdir().unwrap();
    let file = Nifti::new(VoxelType::U8, &[3, 4, 5], false).with(&noise(VoxelType::U8, 60, 1));
    let text = said(&keep(&folder, "a.nii.gz", &gzip(&gzip(&file))));
    assert!(text.contains("this is a file compressed with gzip twice; unpack it once (gunzip)"), "{text}");
    // The image of a pair.
    let mut header = Nifti::new(VoxelType::U8, &[3, 4, 5], false);
    header.bytes[344..348].copy_from_slice(b"ni1\0");
    header.f32(108, 0.0);
    let path = keep(&folder, "p.hdr", &header.bytes[..348]);
    keep(&folder, "p.img.gz", &gzip(&gzip(noise(VoxelType::U8, 60, 1).as_bytes())));
    let text = io::open(path).unwrap_err().to_string();
    assert!(text.contains("found gzip inside gzip") && text.contains("twice"), "{text}");
}

#[test]
fn what_can_be_opened_instead_is_listed_where_that_helps() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in
        [("a.png", &b"\x89PNG\r\n\x1a\n"[..]), ("a.zip", b"PK\x03\x04"), ("a.mha", b"ObjectType = Image")]
    {
        let text = said(&keep(&folder, name, bytes));
        let listed = text.split_once("Burin opens").unwrap_or_else(|| panic!("{text}")).1;
        for format in ["NIfTI-1", "NRRD"] {
            assert!(listed.contains(format), "{text}");
        }
    }
    let page = said(&keep(&folder, "a.html", b"<!DOCTYPE html>"));
    assert!(page.ends_with("get the file again"), "{page}");
    // Fifty bytes a triangle behind a head of 84, and no byte more.
    let mesh = |triangles: u32, bytes: usize| {
        let mut file = vec![b' '; 84 + bytes];
        file[80..84].copy_from_slice(&triangles.to_le_bytes());
        io::open(keep(&folder, "a.stl", &file)).unwrap_err().to_string()
    };
    assert!(mesh(3, 150).contains("an STL surface mesh"));
    for (triangles, bytes) in [(3, 149), (3, 151), (2, 150), (0, 0)] {
        assert!(!mesh(triangles, bytes).contains("STL"), "{triangles} {bytes}");
    }
}

#[test]
fn a_dicom_file_is_known_by_what_comes_before_a_sequence_without_a_length() {
    let folder = tempfile::tempdir().unwrap();
    for explicit in [false, true] {
        let sequence = |mut file: Vec<u8>| {
            file.extend_from_slice(&[8, 0, 0x40, 0x11]);
            file.extend_from_slice(if explicit { b"SQ\0\0" } else { b"" });
            file.extend_from_slice(&[0xff; 4]);
            file.extend_from_slice(b"items, who knows how many");
            file
        };
        let first = element(false, explicit, (8, 5), b"CS", b"ISO_IR 100");
        let second = element(false, explicit, (8, 8), b"CS", b"ORIGINAL");
        // No element of DICOM is of odd length.
        let odd = element(false, explicit, (8, 8), b"CS", b"ODD");
        assert!(!said(&keep(&folder, "a", &sequence([first.clone(), odd].concat()))).contains("DICOM"));
        let text = said(&keep(&folder, "a", &sequence([first, second].concat())));
        assert!(text.contains("this is a DICOM file (without"), "{explicit}: {text}");
        assert!(!said(&keep(&folder, "a", &sequence(Vec::new()))).contains("DICOM"));
    }
}
