//! Segments that a NRRD header names as 3D Slicer does.

use super::files::*;
use burin::io;
use burin::io::{NamedLabel, Opened};

fn open(components: usize, keys: &[&str]) -> Opened {
    let folder = tempfile::tempdir().unwrap();
    let sizes = format!("sizes: {components} 3 4 5");
    let lines = ["type: uint8", "dimension: 4", &sizes, "kinds: list domain domain domain", "encoding: raw"];
    let path = keep(&folder, "a.seg.nrrd", &nrrd(&[&lines, keys].concat(), &vec![0; components * 60]));
    io::open(path).unwrap()
}

fn label(value: i128, name: &str, colour: Option<[f32; 3]>, component: u32) -> NamedLabel {
    NamedLabel { value, name: Some(name.into()), colour, component }
}

#[test]
fn names_colours_values_and_layers_are_the_headers() {
    let opened = open(
        2,
        &[
            "Segment1_Name:=kidney\\nleft\\\\",
            "Segment0_ID:=Segment_1",
            "Segment0_Name:=liver: the whole",
            "Segment0_Color:=0.5 0.25 1",
            "Segment0_LabelValue:=7",
            "Segment0_Layer:=0",
            "Segment0_Extent:=0 2 0 3 0 4",
            "Segment1_Color:=0 0 0",
            "Segment1_LabelValue:=7",
            "Segment1_Layer:=1",
            "Segment10_ID:=only an id",
            "Segment10_LabelValue:=300",
            "Segmentation_MasterRepresentation:=Binary labelmap",
        ],
    );
    let left = label(7, "kidney\nleft\\", Some([0.0; 3]), 1);
    let liver = label(7, "liver: the whole", Some([0.5, 0.25, 1.0]), 0);
    assert_eq!(opened.labels, [liver.clone(), left.clone(), label(300, "only an id", None, 0)]);
    assert_eq!(opened.labels_of(1), [left]);
    let said = opened.left_out(0).unwrap();
    assert!(said.contains("2 layers, which may overlap; the first is taken: kidney"), "{said}");
    assert!(
        opened.left_out(1).unwrap().contains("number 1, counted from 0, is taken: liver: the whole, only an id left")
    );
    assert!(open(1, &[]).left_out(0).is_none());
}

#[test]
fn what_is_told_of_a_file_names_its_format_and_its_segments() {
    let folder = tempfile::tempdir().unwrap();
    let told = |name: &str, bytes: &[u8]| {
        serde_json::to_value(io::info(keep(&folder, name, bytes), &|_| true).unwrap()).unwrap()
    };
    let lines = ["type: uint8", "dimension: 1", "sizes: 2", "Segment0_Name:=a", "Segment0_LabelValue:=7"];
    let nrrd = |encoding: &str, data: &[u8]| nrrd(&[&lines[..], &[&format!("encoding: {encoding}")]].concat(), data);
    for (encoding, data, format) in [
        ("raw", vec![1, 2], "NRRD, raw"),
        ("gz", gzip(&[1, 2]), "NRRD, gzip"),
        ("bz2", bzip2(&[1, 2]), "NRRD, bzip2"),
        ("hex", b"0102".to_vec(), "NRRD, hex"),
        ("ascii", b"1 2".to_vec(), "NRRD, text"),
    ] {
        let told = told("a.seg.nrrd", &nrrd(encoding, &data));
        assert_eq!((&told["format"], told["max"].as_f64()), (&format.into(), Some(2.0)));
        assert_eq!((&told["segments"][0]["value"], &told["segments"][0]["name"]), (&7.into(), &"a".into()));
    }
    let first = Nifti::new(burin::volume::VoxelType::U8, &[2], false);
    let second = Nifti::second(burin::volume::VoxelType::U8, &[2], true);
    let file = |n: &Nifti| [&n.bytes[..], &[1, 2]].concat();
    for (bytes, format) in
        [(file(&first), "NIfTI-1"), (gzip(&file(&first)), "NIfTI-1, gzip"), (file(&second), "NIfTI-2")]
    {
        let told = told("a.nii", &bytes);
        assert_eq!((&told["format"], told.get("segments")), (&format.into(), None));
    }
}

#[test]
fn older_files_have_a_layer_for_each_segment() {
    let keys = ["Segment0_Name:=a", "Segment1_Name:=b", "Segment2_Name:=c"];
    let opened = open(3, &keys);
    assert_eq!(opened.labels, [label(1, "a", None, 0), label(1, "b", None, 1), label(1, "c", None, 2)]);
    assert_eq!(open(1, &keys[1..2]).labels, [label(1, "b", None, 0)]);
}

#[test]
fn odd_segments_are_told_and_not_used() {
    let opened = open(
        1,
        &[
            "Segment0_Name:=a",
            "Segment0_LabelValue:=one",
            "Segment1_LabelValue:=2",
            "Segment1_Layer:=5",
            "Segment2_LabelValue:=3",
            "Segment2_Color:=2 0 0",
            "Segment3_LabelValue:=3",
            "Segment3_Name:=again",
            "Segment4_LabelValue:=0",
            "Segment99999999999999_Name:=no",
            "SegmentX_Name:=no",
            "Segment_Name:=no",
        ],
    );
    assert_eq!(opened.labels, [NamedLabel { value: 3, name: None, colour: None, component: 0 }]);
    let said = opened.warnings.join("\n");
    for part in [
        "Segment0 has label value one",
        "Segment1 has label value 2 in layer 5",
        "Segment2_Color",
        "Segment3 has",
        "Segment4 has",
    ] {
        assert!(said.contains(part), "{part} in {said}");
    }
    let many: Vec<String> = (0..1000).map(|n| format!("Segment{n}_LabelValue:=x")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    assert_eq!(open(1, &many).warnings.len(), 8);
}
