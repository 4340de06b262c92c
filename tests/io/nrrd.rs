//! Fields of NRRD headers: what is taken, what is refused, and in which words.

use super::files::*;
use burin::io;
use burin::volume::{VoxelType, Voxels};

const PLAIN: [&str; 5] = ["type: short", "dimension: 3", "sizes: 3 4 5", "endian: big", "encoding: raw"];

/// More bytes than can be counted.
const BEYOND: [&str; 5] =
    ["type: short", "dimension: 3", "sizes: 4000000 3000000 2000000", "endian: big", "encoding: raw"];

fn voxels() -> Voxels {
    noise(VoxelType::I16, 60, 1)
}

fn data() -> Vec<u8> {
    bytes_of(&voxels(), true)
}

fn holds(path: &std::path::Path) {
    let source = io::open(path).unwrap().source(0, 0, &|_| true).unwrap();
    assert_eq!(source.read([0; 3], [3, 4, 5]).unwrap(), voxels());
}

fn with(lines: &[&str]) -> Vec<u8> {
    nrrd(&[&PLAIN, lines].concat(), &data())
}

/// PLAIN with one line in another's place; the error must name file and field, what was found and what was expected.
fn refused(folder: &tempfile::TempDir, line: &str, field: &str, found: &str) -> String {
    let name = line.split(':').next().unwrap();
    let kept: Vec<_> = PLAIN.into_iter().filter(|l| !l.starts_with(&format!("{name}:"))).collect();
    let lines = [&kept[..], &[line]].concat();
    let text = io::open(keep(folder, "bad.nrrd", &nrrd(&lines, &data()))).unwrap_err().to_string();
    for part in ["bad.nrrd", field, &format!("found {found}"), "expected"] {
        assert!(text.contains(part), "no {part} in: {text}");
    }
    text
}

#[test]
fn headers_are_read_as_people_write_them() {
    let folder = tempfile::tempdir().unwrap();
    let open = |bytes: &[u8]| holds(&keep(&folder, "a.nrrd", bytes));
    open(&with(&[]));
    for magic in ["NRRD0001", "NRRD0002", "NRRD0003", "NRRD0004", "NRRD0005", "NRRD00.01"] {
        open(&[magic.as_bytes(), &with(&[])[8..]].concat());
    }
    open(&with(&["# a comment: with a colon", "key:=value", "a key:=with: colon", "content: a head", "old min: 0"]));
    open(&with(&["kinds: domain  domain\tdomain", "centers: cell cell cell", "labels: \"x y\" \"\" \"z\""]));
    open(&with(&["oldmax: 3", "thicknesses: NaN NaN 2", "measurement frame: (1,0,0) (0,1,0) (0,0,1)"]));
    let crlf = String::from("NRRD0004\r\n") + &PLAIN.join("\r\n") + "\r\n\r\n";
    open(&[crlf.as_bytes(), &data()].concat());
    open(&[b"NRRD0004\nType:short\nDIMENSION:  3\nsizes:3 4 5\nEndian: BIG\nencoding: Raw\n\n", &data()[..]].concat());
    let opened = io::open(keep(&folder, "a.nrrd", &with(&["colour: red"]))).unwrap();
    assert!(opened.warnings[0].contains("colour"), "{:?}", opened.warnings);
}

#[test]
fn an_axis_that_loses_its_direction_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let with_axes = |vectors: &str| {
        let lines = ["space: RAS", &format!("space directions: {vectors}")];
        io::open(keep(&folder, "a.nrrd", &with(&lines))).unwrap()
    };
    let odd = with_axes("(1,0,0) (nan,nan,nan) (0,0,1)");
    assert_eq!((odd.grid.dims, odd.components), ([3, 5, 1], 4));
    assert!(odd.warnings.iter().any(|w| w.contains("axis 1 has no direction")), "{:?}", odd.warnings);
    assert!(with_axes("(1,0,0) (0,1,0) (0,0,1)").warnings.is_empty());
}

#[test]
fn an_axis_without_direction_and_kind_counts_frames_only_where_it_comes_last() {
    let folder = tempfile::tempdir().unwrap();
    for (axes, sizes, components, frames) in [
        ("none (1,0,0) (0,1,0) (0,0,1)", "2 3 4 5", 2, 1),
        ("(1,0,0) none (0,1,0) (0,0,1)", "3 2 4 5", 2, 1),
        ("(1,0,0) (0,1,0) (0,0,1) none", "3 4 5 2", 1, 2),
        ("(1,0,0) (0,1,0) (0,0,1) none none", "3 4 5 2 2", 2, 2),
    ] {
        let n = sizes.split(' ').count();
        let lines = [
            "type: short".to_owned(),
            format!("dimension: {n}"),
            format!("sizes: {sizes}"),
            "space: RAS".into(),
            format!("space directions: {axes}"),
            "endian: little".into(),
            "encoding: raw".into(),
        ];
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        let voxels = noise(VoxelType::I16, 60 * components as usize * frames as usize, 5);
        let opened = io::open(keep(&folder, "a.nrrd", &nrrd(&lines, &bytes_of(&voxels, false)))).unwrap();
        assert_eq!((opened.components, opened.frames, opened.grid.dims), (components, frames, [3, 4, 5]), "{axes}");
    }
}

#[test]
fn headers_that_cannot_be_are_refused_by_field() {
    let folder = tempfile::tempdir().unwrap();
    let bad = |line: &str, field: &str, found: &str| refused(&folder, line, field, found);
    bad("dimension: 0", "dimension", "0");
    bad("dimension: 17", "dimension", "17");
    bad("dimension: three", "dimension", "three");
    bad("sizes: 3 4", "sizes", "2 entries");
    bad("sizes: 3 0 5", "sizes", "0");
    bad("sizes: 3 -4 5", "sizes", "-4");
    bad("sizes: 3 4.5 5", "sizes", "4.5");
    bad("sizes: 3 99999999999999999999999 5", "sizes", "99999999999999999999999");
    bad("sizes: 3 4294967295 5", "sizes", "4294967295");
    bad("type: char", "type", "char");
    bad("type: block", "type", "block");
    bad("type:", "type", "nothing");
    bad("endian: middle", "endian", "middle");
    bad("encoding: zstd", "encoding", "zstd");
    bad("space: left", "space", "left");
    bad("space dimension: 5", "space dimension", "5");
    bad("space dimension: 1", "space dimension", "1");
    bad("space directions: (1,0,0) (0,1,0) (0,0,1)", "space", "nothing");
    bad("kinds: domain domain", "kinds", "2 entries");
    bad("kinds: list list list", "kinds", "0 axes of space");
    bad("spacings: 1 1 one", "spacings", "one");
    bad("byte skip: two", "byte skip", "two");
    bad("line skip: -1", "line skip", "-1");
    bad("no colon", "header line", "no colon");
    for missing in ["dimension", "sizes", "type", "endian", "encoding"] {
        let lines: Vec<_> = PLAIN.into_iter().filter(|l| !l.starts_with(missing)).collect();
        let text = io::open(keep(&folder, "bad.nrrd", &nrrd(&lines, &data()))).unwrap_err().to_string();
        assert!(text.contains(&format!("{missing}: found nothing; expected")), "{text}");
    }
    let error = |lines: &[&str]| io::open(keep(&folder, "bad.nrrd", &with(lines))).unwrap_err().to_string();
    let text = error(&["type: float"]);
    assert!(text.contains("type: found \"short\" and then \"float\"; expected"), "{text}");
    let space = |vectors: &str| error(&["space: RAS", &format!("space directions: {vectors}")]);
    for vectors in
        ["(1,0,0) (0,1,0)", "(1,0,0) (0,1,0) (0,0)", "(1,0,0) (0,1,0) (0,0,inf)", "1 0 0", "(1,0,0) (2,0,0) (0,0,1)"]
    {
        let text = space(vectors);
        assert!(text.contains("space directions: found"), "{text}");
    }
    assert!(space("(1,0,0) (0,0,0) (0,0,1)").contains("0.0 mm along j"));
    assert!(space("none none none").contains("0 axes of space"));
    let text = error(&["space: RAS", "space directions: (1,0,0) (0,1,0) (0,0,1)", "space origin: (1,nan,0)"]);
    assert!(text.contains("space origin: found (1,nan,0)"), "{text}");
    let text = io::open(keep(&folder, "bad.nrrd", b"NRRD0009\n")).unwrap_err().to_string();
    assert!(text.contains("magic: found NRRD0009; expected NRRD0001"), "{text}");
    let text = io::open(keep(&folder, "bad.nrrd", &nrrd(&BEYOND, &data()))).unwrap_err().to_string();
    assert!(text.contains("found a file of") && text.contains("expected less than 2^64 bytes"), "{text}");
}

#[test]
fn voxels_begin_where_the_skips_say() {
    let folder = tempfile::tempdir().unwrap();
    let file = |lines: &[&str], data: &[u8]| holds(&keep(&folder, "a.nrrd", &nrrd(&[&PLAIN, lines].concat(), data)));
    file(&["byte skip: 7"], &[&[10; 7], &data()[..], b"behind"].concat());
    file(&["line skip: 2"], &[b"one\n\n", &data()[..]].concat());
    file(&["lineskip: 1", "byteskip: 3"], &[b"a line of text\r\nabc", &data()[..]].concat());
    file(&["byte skip: -1"], &[b"any length of text\n\n", &data()[..]].concat());
    file(&["byte skip: -5"], &[b"before", &data()[..], b"4321"].concat());
    let packed = ["type: short", "dimension: 3", "sizes: 3 4 5", "endian: big", "encoding: gz"];
    let file = |lines: &[&str], data: &[u8]| holds(&keep(&folder, "a.nrrd", &nrrd(&[&packed, lines].concat(), data)));
    // Lines are skipped before inflating, bytes after.
    file(&["line skip: 1", "byte skip: 3"], &[b"text\n", &gzip(&[b"abc", &data()[..]].concat())[..]].concat());
    // Two members are one stream; what follows the last is nobody's.
    file(&[], &[&gzip(&data()[..50])[..], &gzip(&data()[50..]), b"rubbish"].concat());
}

#[test]
fn a_detached_header_reads_its_own_folder_only() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("inner")).unwrap();
    keep(&folder, "a.raw", &data());
    keep(&folder, "inner/b.raw", &data());
    let header = |name: &str| {
        let text = format!("NRRD0004\n{}\ndata file: {name}\n", PLAIN.join("\n"));
        keep(&folder, "a.nhdr", text.as_bytes())
    };
    for name in ["a.raw", "./a.raw", "inner/b.raw"] {
        holds(&header(name));
    }
    keep(&folder, "inner/c.nhdr", &std::fs::read(header("../a.raw")).unwrap());
    let absolute = folder.path().join("a.raw");
    for path in [folder.path().join("inner/c.nhdr"), header("inner/../a.raw"), header(absolute.to_str().unwrap())] {
        let text = io::open(path).unwrap_err().to_string();
        assert!(text.contains("data file: found") && text.contains("own folder"), "{text}");
    }
    for name in [".", "inner", "missing.raw"] {
        assert!(io::open(header(name)).unwrap_err().to_string().contains("data file: found"));
    }
    // An attached data file still starts at its own first byte.
    let text = format!("NRRD0004\n{}\ndatafile: a.raw\nbyte skip: -1\n\nignored", PLAIN.join("\n"));
    holds(&keep(&folder, "d.nhdr", text.as_bytes()));
}
