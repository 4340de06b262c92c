//! Voxels of NRRD files in every encoding, behind every skip, in one file and in series of them.

use super::files::*;
use burin::io;
use burin::io::IoError;
use burin::volume::{VoxelType, Voxels};
use burin::with_voxels;
use rand::Rng;
use std::path::Path;

const DIMS: [usize; 3] = [5, 4, 6];

fn lines(ty: VoxelType, big: bool, encoding: &str) -> Vec<String> {
    let name = match ty {
        VoxelType::F32 => "float".to_owned(),
        VoxelType::F64 => "double".to_owned(),
        VoxelType::U8 | VoxelType::U16 | VoxelType::U32 | VoxelType::U64 => format!("uint{}", ty.bytes() * 8),
        _ => format!("int{}", ty.bytes() * 8),
    };
    let endian = if big { "big" } else { "little" };
    [format!("type: {name}"), "dimension: 3".into(), format!("sizes: {} {} {}", DIMS[0], DIMS[1], DIMS[2])]
        .into_iter()
        .chain([format!("endian: {endian}"), format!("encoding: {encoding}")])
        .collect()
}

fn file(lines: &[String], more: &[&str], data: &[u8]) -> Vec<u8> {
    let all: Vec<&str> = lines.iter().map(String::as_str).chain(more.iter().copied()).collect();
    nrrd(&all, data)
}

/// All voxels, and a box of them, as the reference has it.
fn holds(path: &Path, expected: &Voxels) {
    let dims = DIMS.map(|d| d as u32);
    let opened = io::open(path).unwrap_or_else(|e| panic!("{e}"));
    let source = opened.source(0, 0, &|_| true).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(source.read([0; 3], dims).unwrap().as_bytes(), expected.as_bytes(), "{path:?}");
    let (lo, size) = ([1, 2, 1], [3, 2, 4]);
    let part = reference_box(expected, dims, lo, size);
    assert_eq!(source.read(lo, size).unwrap().as_bytes(), part.as_bytes(), "{path:?}");
    // What the values are summed from is the same stream.
    let finite: Vec<f64> = with_voxels!(expected, v => v.iter().map(|x| burin::volume::Value::to_f64(*x)).filter(|x| x.is_finite()).collect());
    let info = io::info(path, &|_| true).unwrap();
    assert_eq!(info.min.map(|n| n.to_f64()), finite.iter().copied().reduce(f64::min));
    assert_eq!(info.max.map(|n| n.to_f64()), finite.iter().copied().reduce(f64::max));
}

fn hex(bytes: &[u8], random: &mut impl Rng) -> Vec<u8> {
    let mut out = Vec::new();
    for byte in bytes {
        let digits = if random.random() { format!("{byte:02x}") } else { format!("{byte:02X}") };
        for digit in digits.bytes() {
            out.push(digit);
            out.extend_from_slice([&b""[..], b"", b"", b" ", b"\n", b"\r\n\t"][random.random_range(0..6)]);
        }
    }
    out
}

/// Numbers so that they read back exactly, as Rust and C write them.
fn text(voxels: &Voxels, random: &mut impl Rng) -> Vec<u8> {
    let mut out = String::from([" ", "", "\n"][random.random_range(0..3)]);
    let words: Vec<String> = with_voxels!(voxels, v => v.iter().map(|x| format!("{x:?}")).collect());
    for word in words {
        out += &word;
        out += [" ", "\n", ", ", ",", "\t\t", " \r\n"][random.random_range(0..6)];
    }
    out.into_bytes()
}

fn encoded(encoding: &str, voxels: &Voxels, big: bool, random: &mut impl Rng) -> Vec<u8> {
    let raw = bytes_of(voxels, big);
    match encoding {
        "raw" => raw,
        "gzip" | "gz" => gzip(&raw),
        "bzip2" | "bz2" => bzip2(&raw),
        "hex" => hex(&raw, random),
        _ => text(voxels, random),
    }
}

fn count() -> usize {
    DIMS.iter().product()
}

/// NaN has many patterns of bits and one word.
fn plain(ty: VoxelType, seed: u64) -> Voxels {
    let mut voxels = noise(ty, count(), seed);
    match &mut voxels {
        Voxels::F32(v) => v.iter_mut().filter(|x| x.is_nan()).for_each(|x| *x = f32::INFINITY),
        Voxels::F64(v) => v.iter_mut().filter(|x| x.is_nan()).for_each(|x| *x = f64::NEG_INFINITY),
        _ => {}
    }
    voxels
}

#[test]
fn every_encoding_of_every_type_and_byte_order_is_read_attached_and_detached() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = random(5);
    for ty in ALL_TYPES {
        let voxels = plain(ty, 17);
        for encoding in ["raw", "gzip", "gz", "bzip2", "bz2", "hex", "ascii", "text", "txt", "ASCII"] {
            for big in [false, true] {
                let data = encoded(encoding, &voxels, big, &mut random);
                let lines = lines(ty, big, encoding);
                holds(&keep(&folder, "a.nrrd", &file(&lines, &[], &data)), &voxels);
                keep(&folder, "a.data", &data);
                holds(&keep(&folder, "a.nhdr", &file(&lines, &["data file: a.data"], b"")), &voxels);
            }
        }
        // Text has no order of bytes: it need not be said.
        let lines: Vec<String> = lines(ty, false, "txt").into_iter().filter(|l| !l.starts_with("endian")).collect();
        holds(&keep(&folder, "a.nrrd", &file(&lines, &[], &text(&voxels, &mut random))), &voxels);
    }
}

#[test]
fn numbers_in_text_are_taken_as_programs_write_them() {
    let folder = tempfile::tempdir().unwrap();
    let read = |ty: &str, text: &str| {
        let n = text.split([' ', ',', '\n']).filter(|w| !w.is_empty()).count();
        let lines = [&format!("type: {ty}"), "dimension: 1", &format!("sizes: {n}"), "encoding: ascii"];
        let opened = io::open(keep(&folder, "a.nrrd", &nrrd(&lines, text.as_bytes())))?;
        let source = opened.source(0, 0, &|_| true)?;
        Ok::<_, IoError>(source.read([0; 3], [n as u32, 1, 1]).unwrap())
    };
    assert_eq!(read("uint8", "0 007 255 3.0 1e2,+5").unwrap(), Voxels::U8(vec![0, 7, 255, 3, 100, 5]));
    assert_eq!(read("int8", "-128,127").unwrap(), Voxels::I8(vec![-128, 127]));
    assert_eq!(
        read("uint64", "18446744073709551615\n9007199254740993").unwrap(),
        Voxels::U64(vec![u64::MAX, (1 << 53) + 1])
    );
    assert_eq!(read("int64", "-9223372036854775808 1").unwrap(), Voxels::I64(vec![i64::MIN, 1]));
    assert_eq!(
        read("float", "inf -inf 1.5e-3 .5").unwrap(),
        Voxels::F32(vec![f32::INFINITY, f32::NEG_INFINITY, 1.5e-3, 0.5])
    );
    let Voxels::F64(odd) = read("double", "nan NaN -nan 0.1").unwrap() else { panic!() };
    assert!(odd[..3].iter().all(|x| x.is_nan()) && odd[3] == 0.1);
    // Written out in full, as C's %f does.
    let ends = format!("{:.6} {:.1074}", f64::MAX, f64::from_bits(1));
    assert_eq!(read("double", &ends).unwrap(), Voxels::F64(vec![f64::MAX, f64::from_bits(1)]));
    for (ty, text, found) in [
        ("uint8", "1 256", "\"256\" as number 2 is no u8"),
        ("uint8", "-1 2", "\"-1\" as number 1 is no u8"),
        ("int16", "1 2 32768", "\"32768\" as number 3 is no i16"),
        ("int32", "1.5 2", "\"1.5\" as number 1 is no i32"),
        ("float", "1 two", "\"two\" as number 2 is no f32"),
        ("uint64", "18446744073709551616 0", "is no u64"),
        ("uint8", &format!("1 {}", "9".repeat(5000)), "as number 2 is none"),
    ] {
        let error = read(ty, text).unwrap_err().to_string();
        assert!(error.contains("a.nrrd: voxel data in text: found damage") && error.contains(found), "{error}");
    }
    let lines = ["type: uint8", "dimension: 1", "sizes: 4", "encoding: hex"];
    for (data, found) in [("00 1g 02 03", "\"g\" after 3 digits"), ("0011223x", "\"x\" after 7 digits")] {
        let path = keep(&folder, "a.nrrd", &nrrd(&lines, data.as_bytes()));
        let error = io::open(&path).unwrap().source(0, 0, &|_| true).unwrap_err().to_string();
        assert!(error.contains("a.nrrd: voxel data in hex: found damage") && error.contains(found), "{error}");
    }
}

#[test]
fn skips_count_in_the_file_by_lines_and_in_what_is_decoded_by_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = random(6);
    let voxels = plain(VoxelType::I32, 3);
    let raw = bytes_of(&voxels, true);
    for encoding in ["raw", "gzip", "bzip2"] {
        let pack = |bytes: &[u8]| match encoding {
            "gzip" => gzip(bytes),
            "bzip2" => bzip2(bytes),
            _ => bytes.to_vec(),
        };
        for (skip, before, behind) in [
            ("0", "", ""),
            ("7", "1234567", "more"),
            ("-1", "any length of text", ""),
            ("-1", "", ""),
            ("-5", "before", "4321"),
            ("-2", "", "1"),
        ] {
            let data = pack(&[before.as_bytes(), &raw, behind.as_bytes()].concat());
            for lined in [false, true] {
                let text = if lined { &b"one\n\ntwo\r\n"[..] } else { b"" };
                let skips = [format!("line skip: {}", if lined { 3 } else { 0 }), format!("byte skip: {skip}")];
                let skips = skips.each_ref().map(String::as_str);
                let lines = lines(VoxelType::I32, true, encoding);
                let data = [text, &data].concat();
                holds(&keep(&folder, "a.nrrd", &file(&lines, &skips, &data)), &voxels);
                keep(&folder, "a.data", &data);
                let detached = [&skips[..], &["datafile: a.data"]].concat();
                holds(&keep(&folder, "a.nhdr", &file(&lines, &detached, b"")), &voxels);
            }
        }
    }
    for encoding in ["hex", "text"] {
        let data = [b"12345", &encoded(encoding, &voxels, true, &mut random)[..]].concat();
        let lines = lines(VoxelType::I32, true, encoding);
        holds(&keep(&folder, "a.nrrd", &file(&lines, &["byte skip: 5"], &data)), &voxels);
        let lined = [b"a line\n", &data[..]].concat();
        holds(&keep(&folder, "a.nrrd", &file(&lines, &["byte skip: 5", "line skip: 1"], &lined)), &voxels);
        let text = io::open(keep(&folder, "a.nrrd", &file(&lines, &["byte skip: -1"], &data))).unwrap_err().to_string();
        assert!(text.contains(&format!("byte skip: found -1; expected 0 or more: {encoding}")), "{text}");
    }
}

/// The bytes of the axes beyond the first `axes`, one file each.
fn cut(raw: &[u8], files: usize) -> Vec<&[u8]> {
    raw.chunks(raw.len() / files).collect()
}

#[test]
fn a_series_of_files_is_one_volume_by_list_and_by_pattern() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    let mut random = random(7);
    for (round, encoding) in ["raw", "gzip", "bzip2", "hex", "text"].into_iter().cycle().take(15).enumerate() {
        let ty = ALL_TYPES[round % 10];
        let voxels = plain(ty, round as u64);
        let big = round % 2 == 1;
        let lines = lines(ty, big, encoding);
        // Files of two axes (the usual), of one, and of all three with two planes each.
        for (subdim, files) in [("", 6), (" 2", 6), (" 1", 24), (" 3", 3)] {
            let width = ty.bytes();
            let bytes = bytes_of(&voxels, false);
            let parts = cut(&bytes, files);
            let (mut names, header) = (Vec::new(), [3, 0, 11][round % 3]);
            for (n, part) in parts.into_iter().enumerate() {
                let mut slab = Voxels::try_zeroed(ty, part.len() / width).unwrap();
                slab.as_bytes_mut().copy_from_slice(part);
                let data = encoded(encoding, &slab, big, &mut random);
                let data = match encoding {
                    "gzip" => gzip(&[vec![9; header], bytes_of(&slab, big)].concat()),
                    "bzip2" => bzip2(&[vec![9; header], bytes_of(&slab, big)].concat()),
                    _ => [vec![b'9'; header], data].concat(),
                };
                let name = format!("sub/d {:03}.part", 40 - 2 * n as i64);
                keep(&folder, &name, &data);
                keep(&folder, &format!("p{:03}.part", 40 - 2 * n as i64), &data);
                names.push(name);
            }
            let skip = format!("byte skip: {header}");
            let list = format!("data file: LIST{subdim}\n{}", names.join("\n"));
            holds(&keep(&folder, "a.nhdr", &file(&lines, &[&skip, &list], b"")), &voxels);
            let last = 40 - 2 * (files as i64 - 1);
            let pattern = format!("data file: p%03d.part 40 {last} -2{subdim}");
            // A number below 0 would have a sign before its zeros.
            if last >= 0 {
                holds(&keep(&folder, "a.nhdr", &file(&lines, &[&skip, &pattern], b"ignored")), &voxels);
            }
        }
    }
}

#[test]
fn names_by_pattern_are_made_as_c_makes_them() {
    let folder = tempfile::tempdir().unwrap();
    let voxels = plain(VoxelType::U8, 1);
    let raw = bytes_of(&voxels, false);
    let lines = lines(VoxelType::U8, false, "raw");
    for (pattern, range, names) in [
        ("a%d.raw", "9 11 1 3", ["a9.raw", "a10.raw", "a11.raw"]),
        ("a%i", "-1 1 1 3", ["a-1", "a0", "a1"]),
        ("%u.raw", "0 9 4 3", ["0.raw", "4.raw", "8.raw"]),
        ("a%04d", "-5 5 5 3", ["a-005", "a0000", "a0005"]),
        ("a%.3dz", "8 10 1 3", ["a008z", "a009z", "a010z"]),
        ("a%3dz", "8 10 1 3", ["a  8z", "a  9z", "a 10z"]),
        ("100%%%d", "1 3 1 3", ["100%1", "100%2", "100%3"]),
        ("./a%d%%", "3 1 -1 3", ["a3%", "a2%", "a1%"]),
    ] {
        let inner = tempfile::tempdir_in(folder.path()).unwrap();
        for (name, part) in names.iter().zip(cut(&raw, 3)) {
            std::fs::write(inner.path().join(name), part).unwrap();
        }
        let line = format!("data file: {pattern} {range}");
        holds(&keep(&inner, "h.nhdr", &file(&lines, &[&line], b"")), &voxels);
    }
    // A name with a sign of per cent that is no number is a name.
    keep(&folder, "50%%.raw", &raw);
    holds(&keep(&folder, "h.nhdr", &file(&lines, &["data file: 50%%.raw"], b"")), &voxels);
}

#[test]
fn a_series_that_cannot_be_is_refused_by_field() {
    let folder = tempfile::tempdir().unwrap();
    let raw = bytes_of(&plain(VoxelType::U8, 1), false);
    for (n, part) in cut(&raw, 6).into_iter().enumerate() {
        keep(&folder, &format!("d{n}"), part);
    }
    let lines = lines(VoxelType::U8, false, "raw");
    let refused = |line: &str, found: &str| {
        let text = io::open(keep(&folder, "h.nhdr", &file(&lines, &[line], b""))).unwrap_err().to_string();
        assert!(
            text.contains("h.nhdr: data file: found") && text.contains(found) && text.contains("expected"),
            "{text}"
        );
        assert!(text.len() < 2000, "{text}");
    };
    refused("data file: LIST\nd0\nd1\nd2\nd3\nd4", "LIST of 5 files; expected 6");
    refused("data file: LIST", "LIST of 0 files");
    refused("data file: LIST 1\nd0\nd1", "expected 24");
    refused("data file: LIST 3\nd0\nd1\nd2\nd3", "4 files; expected a number of files that divides");
    refused("data file: LIST 4\nd0", "1 to 3");
    refused("data file: LIST 0\nd0", "1 to 3");
    refused("data file: LIST two\nd0", "1 to 3");
    refused("data file: LIST\nd0\nd1\nd2\nd3\nd4\nd9", "d9; expected a file; there is none");
    refused("data file: LIST\nd0\nd1\nd2\nd3\nd4\n../d5", "own folder");
    refused("data file: LIST\nd0\nd1\nd2\nd3\nd4\n/etc/passwd", "own folder");
    refused("data file: d%d 0 5 1 9", "1 to 3");
    refused("data file: d%d 0 4 1", "(5 files); expected 6 files");
    refused("data file: d%d 0 5 -1", "no end of files");
    refused("data file: d%d 0 5 0", "no end of files");
    refused("data file: d%d 0 9223372036854775807 1", "files); expected 6 files");
    refused("data file: d%d 1 6 1", "d6; expected a file; there is none");
    refused("data file: ../d%d 0 5 1", "own folder");
    refused("data file: d%d 0 5", "name%03d.raw");
    refused("data file: d%d", "name%03d.raw");
    refused("data file: d%s 0 5 1", "name%03d.raw");
    refused("data file: d%d%d 0 5 1", "name%03d.raw");
    refused("data file: d%", "name%03d.raw");
    refused("data file: d%0999999999d 0 5 1", "at most 64 digits");
    refused("data file: d%.999999999d 0 5 1", "at most 64 digits");
    // One that is too short, whichever it is.
    keep(&folder, "d4", &raw[..19]);
    let text =
        io::open(keep(&folder, "h.nhdr", &file(&lines, &["data file: d%d 0 5 1"], b""))).unwrap_err().to_string();
    assert!(text.contains("a file of 19 bytes") && text.contains("d4)") && text.contains("20 bytes"), "{text}");
    // More files than there can be.
    let huge = [
        "type: uint8",
        "dimension: 3",
        "sizes: 1 4000000000 4000000000",
        "encoding: raw",
        "data file: d%d 0 15999999999999999999 1 1",
    ];
    assert!(io::open(keep(&folder, "h.nhdr", &nrrd(&huge, b""))).is_err());
    let huge = ["type: uint8", "dimension: 2", "sizes: 1 2000000000", "encoding: raw", "data file: d%d 0 1999999999 1"];
    assert!(
        io::open(keep(&folder, "h.nhdr", &nrrd(&huge, b""))).unwrap_err().to_string().contains("d6; expected a file")
    );
}

#[test]
fn a_file_of_a_series_that_changes_is_an_error_where_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let raw = noise(VoxelType::U8, 5 * 4 * 40, 1).as_bytes().to_vec();
    // Few are held open; a file for every voxel are not.
    for (files, sizes, list) in [(40, "5 4 40", false), (800, "1 5 4 40", true)] {
        let mut lines = lines(VoxelType::U8, false, "raw");
        lines[2] = format!("sizes: {sizes}");
        if list {
            lines[1] = "dimension: 4".into();
            lines.push("kinds: list domain domain domain".into());
        }
        for (n, part) in cut(&raw, files).into_iter().enumerate() {
            keep(&folder, &format!("d{n}"), part);
        }
        let line = format!("data file: d%d 0 {} 1{}", files - 1, if list { " 1" } else { " 2" });
        let source =
            io::open(keep(&folder, "h.nhdr", &file(&lines, &[&line], b""))).unwrap().source(0, 0, &|_| true).unwrap();
        assert_eq!(source.read([0; 3], [5, 4, 40]).unwrap().as_bytes(), raw);
        let changed =
            std::fs::OpenOptions::new().write(true).open(folder.path().join(format!("d{}", files / 2))).unwrap();
        changed.set_modified(std::time::SystemTime::now() + std::time::Duration::from_secs(5)).unwrap();
        assert!(source.read([0; 3], [5, 4, 20]).is_ok());
        let text = source.read([0; 3], [5, 4, 40]).unwrap_err().to_string();
        assert!(text.contains("since it was opened"), "{text}");
        // One that is gone is missed where it is not held open, in words without the system's number.
        std::fs::remove_file(folder.path().join(format!("d{}", files - 1))).unwrap();
        let gone = source.read([0, 0, 39], [5, 4, 1]);
        assert_eq!(gone.is_err(), files == 800);
        if let Err(error) = gone {
            assert!(!error.to_string().contains("os error"), "{error}");
        }
    }
}

#[test]
fn a_stream_that_ends_within_frames_that_nobody_asked_for_is_an_error_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = random(8);
    let voxels = plain(VoxelType::I16, 23);
    for encoding in ["hex", "txt", "gzip", "bzip2"] {
        let twice = [bytes_of(&voxels, false), bytes_of(&voxels, false)].concat();
        let mut both = Voxels::try_zeroed(VoxelType::I16, 2 * count()).unwrap();
        both.as_bytes_mut().copy_from_slice(&twice);
        let mut lines = lines(VoxelType::I16, false, encoding);
        lines[1] = "dimension: 4".into();
        lines[2] = format!("sizes: {} {} {} 2", DIMS[0], DIMS[1], DIMS[2]);
        lines.push("kinds: domain domain domain list".into());
        let data = encoded(encoding, &both, false, &mut random);
        let open = |data: &[u8]| io::open(keep(&folder, "a.nrrd", &file(&lines, &[], data))).unwrap();
        assert!(open(&data).source(0, 0, &|_| true).is_ok(), "{encoding}");
        let cut = &data[..data.len() * 9 / 10];
        let opened = open(cut);
        for component in [0, 1] {
            let error = opened.source(component, 0, &|_| true).map(drop).unwrap_err();
            assert!(matches!(error, IoError::Truncated { .. }), "{encoding} {component}: {error}");
        }
    }
    // Frames too large to be gathered at once are passed over; they are missed all the same.
    let mut large = lines(VoxelType::U8, false, "hex");
    large[1] = "dimension: 4".into();
    large[2] = "sizes: 128 128 80 2".into();
    large.push("kinds: domain domain domain list".into());
    let digits = vec![b'7'; 2 * 2 * 128 * 128 * 80];
    for (missing, fits) in [(0, true), (2, false), (2000, false)] {
        // Blanks, so that the file may hold as much as its header says.
        let data = [&digits[..digits.len() - missing], &vec![b' '; missing]].concat();
        let opened = io::open(keep(&folder, "a.nrrd", &file(&large, &[], &data))).unwrap();
        for component in [0, 1] {
            let source = opened.source(component, 0, &|_| true).map(drop);
            assert_eq!(source.is_ok(), fits, "{missing} {component}");
        }
    }
    // Half a byte is none.
    let lines = lines(VoxelType::U8, false, "hex");
    let digits: String = (0..2 * count() - 1).flat_map(|i| [char::from(b"0123456789abcdef"[i % 16]), '\n']).collect();
    let opened = io::open(keep(&folder, "a.nrrd", &file(&lines, &[], digits.as_bytes()))).unwrap();
    let error = opened.source(0, 0, &|_| true).map(drop).unwrap_err();
    assert!(matches!(error, IoError::Truncated { .. }), "{error}");
}

#[test]
fn no_encoding_makes_anyone_believe_more_than_a_file_can_hold() {
    let folder = tempfile::tempdir().unwrap();
    for (encoding, data) in [
        ("ascii", b"1 2 3 4 5 6 7 8 9".to_vec()),
        ("hex", b"00112233".to_vec()),
        ("bzip2", bzip2(&[0; 1000])),
        ("gzip", gzip(&[0; 1000])),
    ] {
        for sizes in ["2000 2000 2000", "65536 65536 65536", "4000000 3000000 2000000"] {
            let sizes = format!("sizes: {sizes}");
            let lines = ["type: double", "dimension: 3", &sizes, "endian: little", &format!("encoding: {encoding}")];
            let error = io::open(keep(&folder, "a.nrrd", &nrrd(&lines, &data))).unwrap_err();
            assert!(matches!(error, IoError::Truncated { .. }), "{error}");
        }
        // One number too few is found when it is read.
        let raw = vec![7; 80];
        let short = match encoding {
            "ascii" => b"7 ".repeat(9),
            "hex" => b"07".repeat(79),
            "bzip2" => bzip2(&raw[..79]),
            _ => gzip(&raw[..79]),
        };
        let lines = ["type: double", "dimension: 1", "sizes: 10", "endian: little", &format!("encoding: {encoding}")];
        let path = keep(&folder, "a.nrrd", &nrrd(&lines, &short));
        let error = io::open(&path).and_then(|o| o.source(0, 0, &|_| true).map(|_| ())).unwrap_err();
        assert!(matches!(error, IoError::Truncated { .. }), "{encoding}: {error}");
        let lines = [
            "type: double",
            "dimension: 1",
            "sizes: 10",
            "endian: little",
            &format!("encoding: {encoding}"),
            "byte skip: -9",
        ];
        if ["gzip", "bzip2"].contains(&encoding) {
            let path =
                keep(&folder, "a.nrrd", &nrrd(&lines, &if encoding == "gzip" { gzip(&raw) } else { bzip2(&raw) }));
            let text = io::open(&path).unwrap().source(0, 0, &|_| true).unwrap_err().to_string();
            assert!(text.contains("found 80 bytes, decoded") && text.contains("80 bytes and 8 behind them"), "{text}");
        }
    }
}

#[test]
fn damage_of_a_bzip2_stream_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let voxels = noise(VoxelType::I16, count(), 4);
    let lines = lines(VoxelType::I16, false, "bzip2");
    let packed = bzip2(&bytes_of(&voxels, false));
    // Two streams are one, as with gzip.
    let raw = bytes_of(&voxels, false);
    holds(&keep(&folder, "a.nrrd", &file(&lines, &[], &[bzip2(&raw[..50]), bzip2(&raw[50..])].concat())), &voxels);
    for place in [packed.len() / 2, packed.len() - 6, 12] {
        let mut damaged = packed.clone();
        damaged[place] ^= 0x10;
        let path = keep(&folder, "a.nrrd", &file(&lines, &[], &damaged));
        let error = io::open(&path).unwrap().source(0, 0, &|_| true).unwrap_err();
        assert!(matches!(error, IoError::Damaged { encoding: "bzip2", .. }), "{error}");
    }
}

#[test]
fn voxels_that_were_compressed_twice_are_named_so() {
    let folder = tempfile::tempdir().unwrap();
    let voxels = noise(VoxelType::I16, count(), 4);
    let lines = lines(VoxelType::I16, false, "gzip");
    let twice = gzip(&gzip(&bytes_of(&voxels, false)));
    let text = io::open(keep(&folder, "a.nrrd", &file(&lines, &[], &twice))).unwrap_err().to_string();
    assert!(text.contains("found gzip inside gzip") && text.contains("twice"), "{text}");
    // Voxels that only begin like gzip are voxels.
    let mut likely = bytes_of(&voxels, false);
    likely[..4].copy_from_slice(&[0x1f, 0x8b, 8, 0]);
    let path = keep(&folder, "a.nrrd", &file(&lines, &[], &gzip(&likely)));
    assert_eq!(
        io::open(path).unwrap().source(0, 0, &|_| true).unwrap().read([0; 3], [5, 4, 6]).unwrap().as_bytes(),
        likely
    );
}
