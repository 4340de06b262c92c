//! Files that lie: nothing is allocated that the file cannot hold, every answer is an error that names something, and no
//! bytes make a reader panic.

use super::files::*;
use burin::io;
use burin::io::IoError;
use burin::volume::VoxelType;
use rand::Rng;
use std::path::Path;

fn error(path: &Path) -> IoError {
    match io::open(path) {
        Err(error) => error,
        Ok(opened) => opened.source(0, 0, &|_| true).map(|_| ()).unwrap_err(),
    }
}

#[test]
fn a_file_that_asks_for_more_than_it_holds_is_refused_before_its_voxels_are_read() {
    let folder = tempfile::tempdir().unwrap();
    // 377 bytes that ask for 18 GB.
    let mut header = Nifti::new(VoxelType::F64, &[1500, 1500, 1000], false);
    header.bytes.extend_from_slice(&[0; 25]);
    let text = io::open(keep(&folder, "a.nii", &header.bytes)).unwrap_err().to_string();
    assert!(text.contains("377 bytes") && text.contains("18000000352 bytes") && text.contains("voxel data"), "{text}");
    // The same compressed: deflate cannot have made 18 GB out of it.
    let text = io::open(keep(&folder, "a.nii.gz", &gzip(&header.bytes))).unwrap_err().to_string();
    assert!(text.contains("holds at most") && text.contains("18000000352 bytes"), "{text}");
    for (sizes, dimension) in
        [("65536 65536 65536", 3), ("4294967296 1 1", 3), ("2147483647 2147483647 2147483647 9", 4)]
    {
        for encoding in ["raw", "gzip"] {
            let lines = [
                "type: double",
                "endian: little",
                &format!("dimension: {dimension}"),
                &format!("sizes: {sizes}"),
                &format!("encoding: {encoding}"),
            ];
            let file = nrrd(&lines, &gzip(&[0; 1000]));
            let error = io::open(keep(&folder, "a.nrrd", &file)).unwrap_err();
            assert!(matches!(error, IoError::Truncated { .. } | IoError::Field { .. }), "{error}");
        }
    }
    let lines = ["type: uchar", "dimension: 1", "sizes: 10", "encoding: raw", "byte skip: 9223372036854775807"];
    assert!(matches!(error(&keep(&folder, "a.nrrd", &nrrd(&lines, &[0; 20]))), IoError::Truncated { .. }));
    let lines = ["type: uchar", "dimension: 1", "sizes: 10", "encoding: raw", "byte skip: -9223372036854775808"];
    assert!(matches!(error(&keep(&folder, "a.nrrd", &nrrd(&lines, &[0; 20]))), IoError::Truncated { .. }));
    let lines = ["type: uchar", "dimension: 1", "sizes: 10", "encoding: raw", "line skip: 9"];
    assert!(matches!(error(&keep(&folder, "a.nrrd", &nrrd(&lines, &[10; 3]))), IoError::Truncated { .. }));
}

#[test]
#[cfg(target_os = "linux")]
fn a_header_alone_makes_nobody_allocate() {
    let folder = tempfile::tempdir().unwrap();
    // 2 MB that deflate could not shrink, and a header that asks for 1.9 GB: deflate might have.
    let mut file = Nifti::new(VoxelType::I16, &[1000, 1000, 950], false).bytes;
    file.extend_from_slice(noise(VoxelType::U8, 2_000_000, 1).as_bytes());
    let path = keep(&folder, "asks.nii.gz", &gzip(&file));
    assert!(io::open(&path).is_ok());
    // With room for the program and little else; KiB in sh.
    let out = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 1500000; exec \"$0\" \"$@\""])
        .arg(crate::common::program())
        .arg("render")
        .args([&path, std::path::Path::new("-o"), &folder.path().join("a.png")])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(2), "{said}");
    // Not "no memory": the voxels were never asked for.
    assert!(
        said.contains("asks.nii.gz: voxel data: found an end after") && said.contains("1900000000 bytes"),
        "{said}"
    );
}

#[test]
fn a_cut_or_damaged_stream_is_an_error_and_not_zeros() {
    let folder = tempfile::tempdir().unwrap();
    let voxels = noise(VoxelType::I16, 30_000, 4);
    let file = Nifti::new(VoxelType::I16, &[30, 100, 10], false).with(&voxels);
    let raw = keep(&folder, "a.nii", &file[..file.len() - 1]);
    assert!(matches!(io::open(&raw), Err(IoError::Truncated { .. })));
    let packed = gzip(&file);
    for cut in [packed.len() - 1, packed.len() - 8, packed.len() / 2, 30_000, 3000] {
        let path = keep(&folder, "a.nii.gz", &packed[..cut]);
        assert!(matches!(error(&path), IoError::Truncated { .. }), "{cut}: {}", error(&path));
        assert!(io::info(&path, &|_| true).is_err());
    }
    // The checksum at the end, and a byte of the voxels.
    for place in [packed.len() - 7, packed.len() / 2] {
        let mut damaged = packed.clone();
        damaged[place] ^= 0x10;
        let path = keep(&folder, "a.nii.gz", &damaged);
        assert!(matches!(error(&path), IoError::Damaged { .. }), "{}", error(&path));
        assert!(matches!(io::info(&path, &|_| true), Err(IoError::Damaged { .. })));
    }
    // A stream that is whole but shorter than its header says.
    let short = gzip(&file[..file.len() - 2]);
    let IoError::Truncated { found, expected, .. } = error(&keep(&folder, "a.nii.gz", &short)) else { panic!("whole") };
    assert_eq!(expected, "60000 bytes");
    // How far it was read: beyond what is there, and no farther than what was wanted.
    let passed: u64 = found.split(' ').find_map(|word| word.parse().ok()).unwrap_or_else(|| panic!("{found}"));
    assert!((59_999..=60_000).contains(&passed), "{found}");
}

#[test]
fn a_file_that_changes_after_it_was_opened_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = Nifti::new(VoxelType::I16, &[30, 100, 10], false).with(&noise(VoxelType::I16, 30_000, 4));
    let path = keep(&folder, "a.nii", &file);
    let source = io::open(&path).unwrap().source(0, 0, &|_| true).unwrap();
    assert!(source.read([0; 3], [30, 100, 10]).is_ok());
    let refused = || {
        let text = source.read([0, 0, 5], [4, 4, 4]).unwrap_err().to_string();
        assert!(text.contains("a.nii") && text.contains("since it was opened"), "{text}");
    };
    // Written over in place: the length is the same, the time is not.
    let opened = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    opened.set_modified(std::time::SystemTime::now() + std::time::Duration::from_secs(5)).unwrap();
    refused();
    opened.set_len(5000).unwrap();
    refused();
}

/// Opens, and where that succeeds reads; both may fail, neither may panic, and a failure must say something of the file.
fn survives(path: &Path) -> bool {
    let read = io::open(path).and_then(|opened| {
        assert!(opened.grid.dims.iter().all(|&d| d > 0));
        assert!(opened.grid.world_from_index.is_finite() && opened.grid.index_from_world().is_finite());
        assert!(opened.components > 0 && opened.frames > 0);
        io::info(path, &|_| true)?;
        let source = opened.source(opened.components - 1, opened.frames - 1, &|_| true)?;
        source.read([0; 3], opened.grid.dims)?;
        Ok(())
    });
    match read {
        Ok(()) => true,
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(path.file_name().unwrap().to_str().unwrap()), "{text}");
            false
        }
    }
}

fn mutate(bytes: &mut Vec<u8>, header: usize, random: &mut impl Rng) {
    const WORDS: [&[u8]; 16] = [
        b"-1",
        b"0",
        b"99999999999",
        b"none",
        b"nan",
        b"(",
        b")",
        b"\n",
        b"\n\n",
        b":",
        b":=",
        b"inf",
        b" ",
        b"\"",
        b",",
        b"1e308",
    ];
    for _ in 0..random.random_range(1..4) {
        let at = random.random_range(0..header.min(bytes.len()).max(1));
        if at >= bytes.len() {
            return;
        }
        match random.random_range(0..7) {
            0 => bytes[at] = random.random(),
            1 => bytes[at] ^= 1 << random.random_range(0..8),
            2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.random_range(0..5)],
            3 => bytes.truncate(at),
            4 => {
                let word = WORDS[random.random_range(0..WORDS.len())];
                bytes.splice(at..at, word.iter().copied());
            }
            5 => {
                let end = (at + random.random_range(1..20)).min(bytes.len());
                bytes.drain(at..end);
            }
            _ => {
                let word = WORDS[random.random_range(0..WORDS.len())];
                let end = (at + word.len()).min(bytes.len());
                bytes.splice(at..end, word.iter().copied());
            }
        }
    }
}

#[test]
fn no_mutated_nifti_makes_the_reader_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = random(21);
    let mut read = 0;
    for round in 0..3000 {
        let ty = ALL_TYPES[round % 10];
        let mut header = Nifti::new(ty, &[5, 4, 3, 2, 1], round % 2 == 0);
        header.i16(252, 1).i16(254, (round % 3 == 0).into()).f32s(256, &[0.1, 0.2, 0.3, 4.0, 5.0, 6.0]);
        header.f32(280, 1.0).f32(300, 2.0).f32(320, 3.0).f32s(112, &[0.5, 1.0]);
        if round % 5 == 4 {
            header = Nifti::second(ty, &[5, 4, 3, 2, 1], round % 2 == 0);
            header.i32(344, 1).i32(348, (round % 3 == 0).into()).f64s(352, &[0.1, 0.2, 0.3, 4.0, 5.0, 6.0]);
            header.f64s(400, &[1.0]).f64s(440, &[2.0]).f64s(480, &[3.0]).f64s(176, &[0.5, 1.0]);
        }
        let mut file = header.with(&noise(ty, 120, round as u64));
        let length = header.bytes.len();
        mutate(&mut file, length, &mut random);
        let path = if round % 4 == 3 {
            let mut packed = gzip(&file);
            if round % 8 == 7 {
                let all = packed.len();
                mutate(&mut packed, all, &mut random);
            }
            keep(&folder, "a.nii.gz", &packed)
        } else {
            keep(&folder, "a.nii", &file)
        };
        read += u32::from(survives(&path));
    }
    // The walk is worth something only if it meets both ends.
    assert!((300..2800).contains(&read), "{read} of 3000 were read");
}

#[test]
fn no_mutated_nrrd_makes_the_reader_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = random(22);
    let mut read = 0;
    let lines = [
        "type: int16",
        "dimension: 4",
        "space: left-posterior-superior",
        "sizes: 2 5 4 3",
        "space directions: none (1,0,0.5) (0,-1,0) (0.1,0,2)",
        "kinds: vector domain domain domain",
        "endian: little",
        "space origin: (1,2.5e1,-3)",
        "space units: \"mm\" \"mm\" \"um\"",
        "byte skip: 2",
        "key:=value",
        "spacings: NaN 1 1 1",
    ];
    for n in 0..3 {
        keep(&folder, &format!("d{n}"), &[n; 82]);
    }
    for round in 0..3000 {
        let data = [vec![0; 2], bytes_of(&noise(VoxelType::I16, 120, round), false)].concat();
        let (encoding, data) = match round % 5 {
            0 => ("encoding: raw", data),
            1 => ("encoding: gzip", gzip(&data)),
            2 => ("encoding: bzip2", bzip2(&data)),
            3 => ("encoding: hex", data.iter().map(|b| format!("{b:02x} ")).collect::<String>().into_bytes()),
            _ => ("encoding: text", data.iter().map(|b| format!("{b} ")).collect::<String>().into_bytes()),
        };
        let lines = if round % 3 == 0 { &lines[..4] } else { &lines[..11] };
        let mut file = nrrd(&[lines, &["endian: little", encoding]].concat(), &data);
        let mut header = file.len() - data.len();
        if round % 7 == 0 {
            let series = ["data file: d%d 0 2 1", "data file: LIST\nd0\nd1\nd2"][round as usize / 7 % 2];
            file = nrrd(&[&lines[..4], &["endian: little", "byte skip: 2", encoding, series]].concat(), b"");
            header = file.len();
        }
        mutate(&mut file, header, &mut random);
        read += u32::from(survives(&keep(&folder, "a.nrrd", &file)));
    }
    assert!((300..2800).contains(&read), "{read} of 3000 were read");
}

#[test]
fn noise_is_no_volume() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = random(23);
    for round in 0..500 {
        let mut bytes = vec![0; random.random_range(0..900)];
        random.fill(&mut bytes[..]);
        let magic: [&[u8]; 4] = [b"NRRD0004\n", &[0x1f, 0x8b, 8, 0], b"", b"\x5c\x01\0\0"];
        let file = [magic[round % 4], &bytes].concat();
        assert!(!survives(&keep(&folder, ["a.nii", "a.nrrd", "a.nii.gz"][round % 3], &file)));
    }
}
