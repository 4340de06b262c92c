//! Which files are asked about: those whose values look like regions, and no others.

use burin::ui::Glance;
use burin::ui::glance;
use std::path::Path;

/// Writes 24 × 24 × 24 voxels of a type, each by its place; `more` is added to the header.
fn write(path: &Path, kind: &str, more: &str, bytes: impl Fn([i32; 3]) -> Vec<u8>) {
    let mut file = format!(
        "NRRD0004\ntype: {kind}\ndimension: 3\nspace: right-anterior-superior\nsizes: 24 24 24\nendian: little\n\
        space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n{more}\n"
    )
    .into_bytes();
    for n in 0..24 * 24 * 24 {
        file.extend(bytes([n % 24, n / 24 % 24, n / 576]));
    }
    std::fs::write(path, file).unwrap();
}

fn inside(p: [i32; 3], radius: i32) -> bool {
    p.iter().map(|x| (2 * x - 23).pow(2)).sum::<i32>() < 4 * radius * radius
}

/// Something like noise, the same every time.
fn rough(p: [i32; 3]) -> u32 {
    let n = (p[0] + 24 * (p[1] + 24 * p[2])) as u32;
    n.wrapping_mul(2_654_435_761) >> 24
}

#[test]
fn label_maps_of_any_type_are_asked_about() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("x.nrrd");
    let region = |p: [i32; 3]| if inside(p, 9) { 1 + u64::from(p[0] > 11) + 2 * u64::from(p[1] > 11) } else { 0 };
    for (kind, id) in [("uint8", 1_u64), ("uint16", 2035), ("int32", 70_000), ("uint64", 1 << 40)] {
        write(&file, kind, "", |p| {
            let width = match kind {
                "uint8" => 1,
                "uint16" => 2,
                "int32" => 4,
                _ => 8,
            };
            (region(p) * id).to_le_bytes()[..width].to_vec()
        });
        assert_eq!(glance(&file, &|| true), Glance::Regions, "{kind}");
    }
    write(&file, "float", "", |p| (region(p) as f32).to_le_bytes().to_vec());
    assert_eq!(glance(&file, &|| true), Glance::Regions, "whole numbers in floats");
    write(&file, "uint8", "", |p| vec![u8::from(inside(p, 6)) * 255]);
    assert_eq!(glance(&file, &|| true), Glance::Regions, "a mask");
}

#[test]
fn a_header_that_names_segments_is_taken_at_its_word() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("x.seg.nrrd");
    write(&file, "uint8", "Segment0_Name:=Liver\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n", |_| vec![0]);
    assert_eq!(glance(&file, &|| true), Glance::Segments);
}

#[test]
fn images_are_opened_without_a_question() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("x.nrrd");
    let image = |what: &str, kind: &str, bytes: &dyn Fn([i32; 3]) -> Vec<u8>| {
        write(&file, kind, "", bytes);
        assert_eq!(glance(&file, &|| true), Glance::Image, "{what}");
    };
    image("a scan of 8 bits", "uint8", &|p| vec![if inside(p, 9) { 40 + (rough(p) >> 2) as u8 } else { 0 }]);
    image("a smooth one", "uint8", &|p| vec![if inside(p, 9) { (p[0] * 9) as u8 } else { 0 }]);
    image("CT", "int16", &|p| (if inside(p, 9) { 40_i16 } else { -1000 }).to_le_bytes().to_vec());
    image("fractions", "float", &|p| (if inside(p, 9) { 0.5_f32 } else { 0.0 }).to_le_bytes().to_vec());
    image("nothing outside", "uint8", &|p| vec![if inside(p, 9) { 200 } else { 10 }]);
    image("nothing at all", "uint8", &|_| vec![0]);
    image("not a number", "float", &|p| (if inside(p, 5) { f32::NAN } else { 0.0 }).to_le_bytes().to_vec());
    let assets = crate::common::root().join("assets");
    assert_eq!(glance(&assets.join("ch2bet.nii.gz"), &|| true), Glance::Image, "a brain with 0 outside");
}

#[test]
fn what_cannot_be_read_or_takes_too_long_is_left_to_opening() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("x.nrrd");
    assert_eq!(glance(&file, &|| true), Glance::Image);
    std::fs::write(&file, "no volume").unwrap();
    assert_eq!(glance(&file, &|| true), Glance::Image);
    write(&file, "uint8", "", |p| vec![u8::from(inside(p, 6))]);
    assert_eq!(glance(&file, &|| false), Glance::Image, "whoever asks has lost patience");
}
