//! What a volume looks like when it was just opened: outliers, values that stand for nothing, one value, one slice, label maps.

use super::maker::run;
use crate::common::one::One;
use burin::document::{Document, ViewName};
use burin::math::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Writes an attached NRRD, RAS; `name` is the type's, `bytes` the voxels'.
pub fn write(path: &Path, name: &str, dims: [usize; 3], spacing: [f64; 3], bytes: &[u8]) {
    let [nx, ny, nz] = dims;
    let [sx, sy, sz] = spacing;
    let mut file = format!(
        "NRRD0004\ntype: {name}\ndimension: 3\nspace: right-anterior-superior\nsizes: {nx} {ny} {nz}\n\
         space directions: ({sx},0,0) (0,{sy},0) (0,0,{sz})\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n"
    )
    .into_bytes();
    file.extend_from_slice(bytes);
    std::fs::write(path, file).unwrap();
}

fn i16s(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| (v.round() as i16).to_le_bytes()).collect()
}

fn u16s(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| (v.round() as u16).to_le_bytes()).collect()
}

fn f32s(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn cube(&self, name: &str, n: usize, bytes: &[u8]) -> PathBuf {
        self.volume(name, [n; 3], [1.0; 3], bytes)
    }

    fn volume(&self, name: &str, dims: [usize; 3], spacing: [f64; 3], bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join("v.nrrd");
        write(&path, name, dims, spacing, bytes);
        path
    }
}

fn open(path: &Path) -> Document {
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path":path}}}).to_string()).unwrap();
    document
}

/// Black and white of the slices' window.
fn window(document: &Document) -> [f64; 2] {
    let window = document.state().unwrap().scene.window();
    [window.level - window.width / 2.0, window.level + window.width / 2.0]
}

fn opacity(document: &Document, value: f64) -> f32 {
    document.state().unwrap().scene.transfer.opacity_at(value)
}

const N: usize = 40;

/// A body of two tissues and bone in air, in Hounsfield units with noise.
fn ct() -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    voxels(|p| {
        let tissue = match p.length() {
            r if r < 4.0 => 700.0,
            r if r < 13.0 => 45.0,
            r if r < 16.0 => -90.0,
            _ => -1000.0,
        };
        tissue + rng.random_range(-25.0..25.0)
    })
}

fn voxels(mut f: impl FnMut(DVec3) -> f64) -> Vec<f64> {
    let at = |i: usize| DVec3::new((i % N) as f64, (i / N % N) as f64, (i / (N * N)) as f64) - (N as f64 - 1.0) / 2.0;
    (0..N * N * N).map(|i| f(at(i))).collect()
}

/// Signal in noise about zero, no unit.
fn mr() -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    voxels(|p| {
        let signal = if p.length() < 9.0 { 520.0 } else { f64::from(u8::from(p.length() < 15.0)) * 300.0 };
        (signal + rng.random_range(-20.0..20.0_f64)).abs()
    })
}

/// Places spread over a volume, not the first.
fn some(count: usize) -> impl Iterator<Item = usize> {
    (0..count).map(move |i| 1 + i * 7919 % (N * N * N - 1))
}

#[test]
fn a_few_outliers_change_neither_window_nor_transfer_function() {
    let folder = Folder::new();
    let clean = open(&folder.cube("short", N, &i16s(&ct())));
    let [black, white] = window(&clean);
    assert!(black < -100.0 && white > 200.0, "{black} {white}");
    let transfer = clean.state().unwrap().scene.transfer.clone();
    for (what, outliers) in [
        ("one at the type's end", vec![-32_768.0]),
        ("one at either end", vec![-32_768.0, 32_767.0]),
        ("one far off", vec![-20_000.0]),
        ("a few", vec![-25_000.0, -18_000.0, 30_000.0, 14_000.0, 32_767.0]),
    ] {
        let mut values = ct();
        some(outliers.len()).zip(&outliers).for_each(|(i, v)| values[i] = *v);
        let document = open(&folder.cube("short", N, &i16s(&values)));
        let found = window(&document);
        assert!(
            (found[0] - black).abs() < 20.0 && (found[1] - white).abs() < 20.0,
            "{what}: {found:?}, {black} {white}"
        );
        assert_eq!(document.state().unwrap().scene.transfer.colour, transfer.colour, "{what}");
        // Voxels and statistics keep them.
        assert_eq!(
            document.state().unwrap().one().statistics.min,
            outliers.iter().copied().fold(-1025.0, f64::min),
            "{what}"
        );
    }
    let clean = window(&open(&folder.cube("float", N, &f32s(&mr()))));
    let mean = 0.5 * (clean[0] + clean[1]);
    assert!(clean[0] >= 0.0 && clean[0] < 40.0 && (500.0..560.0).contains(&clean[1]), "{clean:?}");
    for outliers in [
        vec![f64::from(f32::MAX)],
        vec![f64::from(f32::MIN), f64::from(f32::MAX), f64::INFINITY, f64::NEG_INFINITY, f64::NAN],
        vec![1e20, -9999.0, 1e20],
        vec![-1e6],
        vec![1e6, -1e9, 1e12],
    ] {
        let mut values = mr();
        some(outliers.len()).zip(&outliers).for_each(|(i, v)| values[i] = *v);
        let found = window(&open(&folder.cube("float", N, &f32s(&values))));
        let far = (0..2).map(|i| (found[i] - clean[i]).abs()).fold(0.0, f64::max);
        assert!(far < 0.05 * mean, "{outliers:?}: {found:?}, {clean:?}");
    }
}

#[test]
fn values_that_stand_for_nothing_measured_take_no_greys_and_hide_nothing() {
    let folder = Folder::new();
    let clean = window(&open(&folder.cube("short", N, &i16s(&ct()))));
    let around = |values: Vec<f64>, nothing: f64| -> Vec<f64> {
        let mut i = 0..values.len();
        let outside = voxels(|p| f64::from(u8::from(p.length() > 18.0)));
        values.into_iter().map(|v| if outside[i.next().unwrap()] > 0.0 { nothing } else { v }).collect()
    };
    // Scanners' padding outside the round field of view.
    for nothing in [-32_768.0, -3024.0, -2000.0] {
        let document = open(&folder.cube("short", N, &i16s(&around(ct(), nothing))));
        let found = window(&document);
        assert!((0..2).all(|i| (found[i] - clean[i]).abs() < 30.0), "{nothing}: {found:?}, {clean:?}");
        assert_eq!(opacity(&document, nothing), 0.0);
    }
    for nothing in [1e20, f64::from(f32::MAX), f64::from(f32::MIN), -9999.0, -32_768.0] {
        let document = open(&folder.cube("float", N, &f32s(&around(mr(), nothing))));
        let found = window(&document);
        assert!(found[0] > -1.0 && (480.0..600.0).contains(&found[1]), "{nothing}: {found:?}");
        assert_eq!(opacity(&document, f64::from(nothing as f32)), 0.0, "{nothing} is clear in 3D");
        assert!(opacity(&document, 520.0) > 0.3, "{nothing}: matter is not");
    }
    // Micro-CT: air and matter far above 0, which stands outside the scan or for a dead detector; 65,535 likewise.
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let scan = voxels(|p| if p.length() < 12.0 { 34_000.0 } else { 30_000.0 } + rng.random_range(-800.0..800.0));
    for nothing in [None, Some(0.0), Some(65_535.0)] {
        let values = nothing.map_or(scan.clone(), |nothing| around(scan.clone(), nothing));
        let document = open(&folder.cube("ushort", N, &u16s(&values)));
        let [black, white] = window(&document);
        assert!(
            (28_000.0..30_500.0).contains(&black) && (34_000.0..36_000.0).contains(&white),
            "{nothing:?}: {black} {white}"
        );
        assert!(opacity(&document, 30_000.0) == 0.0 && opacity(&document, 34_500.0) > 0.2, "{nothing:?}");
        assert_eq!(nothing.map_or(0.0, |v| opacity(&document, v)), 0.0, "{nothing:?}");
    }
}

#[test]
fn small_things_are_no_outliers() {
    let folder = Folder::new();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    // 33 voxels of 64,000 in noise, and one voxel in nothing at all.
    let values = voxels(|p| if p.length() < 2.0 { 4000.0 } else { 0.0 } + rng.random_range(0.0..40.0));
    let bright = values.iter().filter(|v| **v > 3000.0).count();
    let document = open(&folder.cube("short", N, &i16s(&values)));
    assert!(bright > 20 && window(&document)[1] > 3000.0, "{bright} {:?}", window(&document));
    assert!(opacity(&document, 4000.0) > 0.3 && opacity(&document, 20.0) == 0.0);
    let mut point = vec![0.0; N * N * N];
    point[N * N * 20 + N * 20 + 20] = 0.7;
    let document = open(&folder.cube("float", N, &f32s(&point)));
    assert!((window(&document)[1] - 0.7).abs() < 0.01, "{:?}", window(&document));
    assert!(opacity(&document, 0.7) > 0.3 && opacity(&document, 0.0) == 0.0);
}

#[test]
fn a_ct_an_mr_and_a_scan_show_what_people_look_for() {
    let folder = Folder::new();
    let document = open(&folder.cube("short", N, &i16s(&ct())));
    let [black, white] = window(&document);
    let grey = |v: f64| ((v - black) / (white - black)).clamp(0.0, 1.0);
    // Soft tissue is a middle grey, air black, bone white, fat between.
    assert!((0.25..0.6).contains(&grey(45.0)) && grey(-1000.0) == 0.0 && grey(700.0) == 1.0, "{black} {white}");
    assert!(grey(45.0) - grey(-90.0) > 0.15);
    assert!(opacity(&document, -1000.0) == 0.0 && opacity(&document, 700.0) > 2.0 * opacity(&document, 45.0));
    let document = open(&folder.cube("short", N, &i16s(&mr())));
    let [black, white] = window(&document);
    let grey = |v: f64| ((v - black) / (white - black)).clamp(0.0, 1.0);
    assert!(grey(10.0) < 0.05 && (0.4..0.7).contains(&grey(300.0)) && grey(500.0) > 0.85, "{black} {white}");
    assert!(opacity(&document, 15.0) == 0.0 && opacity(&document, 520.0) > 0.3);
    // The reset is the same start.
    let before = document.state().unwrap().scene.transfer.clone();
    let mut document = document;
    run(&mut document, r#"{"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,1]],"unit_mm":1}}}}"#)
        .unwrap();
    run(&mut document, r#"{"transfer":{"reset":{}}}"#).unwrap();
    assert_eq!(document.state().unwrap().scene.transfer, before);
}

/// Blocks of labels, `ids` by turns, in 0.
fn label_map(ids: &[u16]) -> Vec<u16> {
    let id = |x: usize, y: usize, z: usize| {
        let block = x / 8 + 5 * (y / 8) + 25 * (z / 8);
        if [x, y, z].iter().any(|c| c % 8 > 5) { 0 } else { ids[block * 7 % ids.len()] }
    };
    (0..N * N * N).map(|i| id(i % N, i / N % N, i / (N * N))).collect()
}

#[test]
fn each_id_of_a_label_map_has_a_colour_of_its_own() {
    let folder = Folder::new();
    let sparse: Vec<u16> = (1..60).map(|i| i * 150 + i % 3).collect();
    for ids in [vec![1], vec![1, 2, 3], (1..27).collect(), (1..117).collect(), vec![2, 41, 1000, 1001], sparse] {
        let values = label_map(&ids);
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let floats: Vec<u8> = values.iter().flat_map(|v| f32::from(*v).to_le_bytes()).collect();
        for (name, bytes) in [("ushort", bytes), ("float", floats)] {
            let document = open(&folder.cube(name, N, &bytes));
            let transfer = &document.state().unwrap().scene.transfer;
            assert_eq!(transfer.opacity_at(0.0), 0.0);
            // As the picture takes them, from the table.
            let table = transfer.table(1.0);
            let (lo, hi) = transfer.domain();
            let colour = |id: u16| {
                let at = (f64::from(id) - lo) / (hi - lo) * (table.len() - 1) as f64 + 0.5;
                table[(at.max(0.0) as usize).min(table.len() - 1)]
            };
            let mut used: Vec<u16> = values.iter().copied().filter(|v| *v != 0).collect();
            used.sort_unstable();
            used.dedup();
            for (i, &a) in used.iter().enumerate() {
                assert!(colour(a)[3] > 0.05, "{name} {a} shows");
                if let Some(&b) = used.get(i + 1) {
                    let apart = (0..3).map(|c| (colour(a)[c] - colour(b)[c]).abs()).fold(0.0, f32::max);
                    assert!(apart > 0.1, "{name} {a} {b} of {used:?}: {:?} {:?}", colour(a), colour(b));
                }
            }
            // Every id has a grey of its own as far as greys go.
            let [black, white] = window(&document);
            assert!(black <= 0.0 && white >= f64::from(used[used.len() - 1]));
        }
    }
}

#[test]
fn a_smooth_picture_of_few_greys_is_no_label_map() {
    let folder = Folder::new();
    let values = voxels(|p| (20.0 - p.length()).max(0.0).round());
    let bytes: Vec<u8> = values.iter().map(|v| *v as u8).collect();
    let document = open(&folder.cube("uchar", N, &bytes));
    let transfer = &document.state().unwrap().scene.transfer;
    assert!(transfer.colour.len() < 8, "{:?}", transfer.colour);
}

/// What is drawn at first: share of pixels that show anything, and how different they are in brightness.
fn seen(document: &mut Document, view: ViewName) -> (f64, f64) {
    let image = document.picture(view, [64, 64], None).unwrap();
    let shown: Vec<f32> =
        image.colour.iter().filter(|c| c[3] > 0.2).map(|c| c[..3].iter().sum::<f32>() / 3.0).collect();
    let ends = shown.iter().fold([f32::INFINITY, 0.0], |[lo, hi], v| [lo.min(*v), hi.max(*v)]);
    (shown.len() as f64 / 4096.0, f64::from(ends[1] - ends[0]).max(0.0))
}

#[test]
fn one_value_alone_is_seen_in_3d_and_in_slices() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = Folder::new();
    let count = 24 * 20 * 16;
    let all = |v: f64| vec![v; count];
    for (name, bytes) in [
        ("uchar", vec![0_u8; count]),
        ("uchar", vec![7_u8; count]),
        ("short", i16s(&all(-1000.0))),
        ("ushort", u16s(&all(65_535.0))),
        ("float", f32s(&all(0.0))),
        ("float", f32s(&all(-5.5))),
        ("float", f32s(&all(1e20))),
        ("float", f32s(&all(-1e37))),
        ("float", f32s(&all(3e38))),
        ("float", f32s(&all(-3.3e38))),
        ("float", f32s(&all(1e-30))),
    ] {
        let mut document = open(&folder.volume(name, [24, 20, 16], [1.0; 3], &bytes));
        let (covered, _) = seen(&mut document, ViewName::ThreeD);
        assert!(covered > 0.1, "{name} {bytes:?}: {covered}", bytes = &bytes[..4]);
        for view in [ViewName::Axial, ViewName::Coronal, ViewName::Sagittal] {
            let image = document.picture(view, [32, 32], None).unwrap();
            let grey = image.colour.iter().find(|c| c[3] > 0.0).unwrap()[0];
            assert!((grey - 0.5).abs() < 0.05, "{name} {view:?} {grey}");
        }
    }
    // Within nothing: the ball is seen as one.
    let ball = voxels(|p| if p.length() < 12.0 { 7.0 } else { f64::NAN });
    let mut document = open(&folder.cube("float", N, &f32s(&ball)));
    let (covered, shape) = seen(&mut document, ViewName::ThreeD);
    assert!((0.03..0.3).contains(&covered) && shape > 0.1, "{covered} {shape}");
    let (covered, _) = seen(&mut document, ViewName::Axial);
    // π·12²/40² of a square, a picture of which is seen whole.
    assert!((covered - 0.28).abs() < 0.05, "{covered}");
    // Nothing at all is no error.
    let mut document = open(&folder.cube("float", 8, &f32s(&[f64::NAN; 512])));
    assert_eq!(seen(&mut document, ViewName::ThreeD).0, 0.0);
}

#[test]
fn a_single_slice_is_seen_from_its_face_as_the_slice_shows_it() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = Folder::new();
    // Dark and bright stripes with a mark in one corner.
    let pixel = |u: usize, v: usize| if u < 12 && v < 6 { 250 } else { (40 + 10 * (u / 4 % 8) + v) as u8 };
    let picture: Vec<u8> = (0..48 * 32).map(|i| pixel(i % 48, i / 48)).collect();
    for (view, dims, spacing) in [
        (ViewName::Axial, [48, 32, 1], [1.0, 1.0, 1.0]),
        (ViewName::Axial, [48, 32, 1], [0.5, 0.5, 6.0]),
        (ViewName::Axial, [48, 32, 1], [1.0, 1.0, 0.01]),
        (ViewName::Coronal, [48, 1, 32], [1.0, 1.0, 1.0]),
        (ViewName::Sagittal, [1, 48, 32], [1.0, 3.0, 3.0]),
    ] {
        let mut document = open(&folder.volume("uchar", dims, spacing, &picture));
        let slice = document.picture(view, [64, 64], None).unwrap().to_rgba8(Some([0.0; 3]));
        // The 3D view, brought to the slice's size.
        let camera = document.state().unwrap().scene.views.camera;
        let plane = burin::document::SlicePlane::new(
            document.state().unwrap().one().grid(),
            &document.state().unwrap().scene.views,
            view,
        )
        .unwrap();
        let height_mm = plane.mm_per_px * f64::from(plane.size[1]);
        let flat = burin::math::Camera { projection: burin::math::Projection::Orthographic { height_mm }, ..camera };
        assert!(plane.towards_viewer.dot(-camera.forward()) > 0.999, "{view:?} is seen from its face");
        let solid = document.picture(ViewName::ThreeD, [64, 64], Some(flat)).unwrap().to_rgba8(Some([0.0; 3]));
        let far = slice.iter().zip(&solid).filter(|(a, b)| a.abs_diff(**b) > 12).count();
        assert!(far * 50 < slice.len(), "{view:?} {spacing:?}: {far} of {} are others", slice.len());
        let (covered, contrast) = seen(&mut document, ViewName::ThreeD);
        assert!(covered > 0.1 && contrast > 0.5, "{view:?} {spacing:?}: {covered} {contrast}");
        // As a surface and as a maximum too.
        for mode in [r#"{"iso":30}"#, r#""mip""#] {
            run(&mut document, &format!(r#"{{"view":{{"look":{{"mode":{mode}}}}}}}"#)).unwrap();
            assert!(seen(&mut document, ViewName::ThreeD).0 > 0.1, "{view:?} {spacing:?} {mode}");
        }
    }
}

#[test]
fn a_picture_of_two_dimensions_is_as_thick_as_its_pixels_are_wide() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.nrrd");
    let mut file =
        b"NRRD0004\ntype: uchar\ndimension: 2\nsizes: 32 24\nspacings: 0.002 0.003\nencoding: raw\n\n".to_vec();
    file.extend((0..32 * 24).map(|i| (i % 200) as u8));
    std::fs::write(&path, file).unwrap();
    let document = open(&path);
    assert!(
        (document.state().unwrap().one().grid().spacing() - DVec3::new(0.002, 0.003, 0.002)).abs().max_element() < 1e-9
    );
    // The same as NIfTI, whose third size is left at 0 or 1.
    for (third, depth) in [(0.0_f32, 1_i16), (1.0, 1), (1.0, 0)] {
        let mut header = vec![0_u8; 352];
        let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, &348_i32.to_le_bytes());
        for (i, n) in [2_i16, 32, 24, depth, 1, 1, 1, 1].into_iter().enumerate() {
            put(40 + 2 * i, &n.to_le_bytes());
        }
        put(70, &2_i16.to_le_bytes());
        put(72, &8_i16.to_le_bytes());
        for (i, n) in [1.0_f32, 0.002, 0.003, third].into_iter().enumerate() {
            put(76 + 4 * i, &n.to_le_bytes());
        }
        put(108, &352.0_f32.to_le_bytes());
        put(123, &[2]);
        put(344, b"n+1\0");
        header.extend((0..32 * 24).map(|i| (i % 200) as u8));
        let path = folder.path().join("p.nii");
        std::fs::write(&path, header).unwrap();
        let spacing = open(&path).state().unwrap().one().grid().spacing();
        assert!((spacing - DVec3::new(0.002, 0.003, 0.002)).abs().max_element() < 1e-8, "{third} {depth}: {spacing}");
    }
    let value: Value = json!(open(&path).state().unwrap().one().grid().dims);
    assert_eq!(value, json!([32, 24, 1]));
}

#[test]
fn slabs_and_rods_are_first_seen_from_their_side() {
    let folder = Folder::new();
    for (dims, spacing, side) in [
        ([40, 40, 3], [1.0, 1.0, 1.0], DVec3::NEG_Z),
        ([40, 2, 40], [1.0, 1.0, 1.0], DVec3::Y),
        ([6, 40, 40], [0.5, 1.0, 1.0], DVec3::NEG_X),
        ([30, 30, 30], [1.0, 1.0, 0.1], DVec3::NEG_Z),
        ([4, 60, 4], [1.0, 1.0, 1.0], DVec3::NEG_X),
        ([60, 4, 4], [1.0, 1.0, 1.0], DVec3::Y),
        ([20, 20, 20], [1.0, 1.0, 1.0], DVec3::Y),
    ] {
        let count: usize = dims.iter().product();
        let bytes: Vec<u8> = (0..count).map(|i| (i * 7 % 251) as u8).collect();
        let document = open(&folder.volume("uchar", dims, spacing, &bytes));
        let forward = document.state().unwrap().scene.views.camera.forward();
        assert!((forward + side).length() < 1e-9, "{dims:?} {spacing:?}: {forward}");
    }
}

#[test]
fn an_automatic_window_has_no_more_digits_than_mean_something() {
    let folder = Folder::new();
    let bytes: Vec<u8> = mr().iter().map(|v| (v / 3.0).round() as u8).collect();
    let of = |name: &str, bytes: &[u8]| {
        let window = open(&folder.cube(name, N, bytes)).state().unwrap().scene.window();
        [window.level, window.width]
    };
    for (name, bytes) in [("uchar", bytes), ("short", i16s(&ct())), ("ushort", u16s(&mr()))] {
        assert!(of(name, &bytes).iter().all(|n| n.fract() == 0.0), "{name}: {:?}", of(name, &bytes));
    }
    // Of fractions three digits of the width, and as many decimals of the level.
    let coarse = of("float", &f32s(&mr().iter().map(|v| v * 1e-4).collect::<Vec<_>>()));
    assert!((0.01..0.1).contains(&coarse[1]), "{coarse:?}");
    for n in coarse {
        assert!((n * 1e4 - (n * 1e4).round()).abs() < 1e-6, "{coarse:?}");
        assert!(format!("{n}").len() <= 6, "{coarse:?}");
    }
    let tiny = of("double", &mr().iter().flat_map(|v| (v * 1e-30).to_le_bytes()).collect::<Vec<_>>());
    assert!(tiny[1] > 1e-29 && tiny[1] < 1e-27 && tiny[0] > 1e-29, "{tiny:?}");
}
