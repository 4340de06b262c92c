//! Where volumes lie: affines in closed form, 48 axis orders, oblique grids, both formats.

use super::files::*;
use burin::io;
use burin::io::Opened;
use burin::math::{DAffine3, DMat3, DQuat, DVec3};
use burin::volume::{VoxelType, Voxels};
use rand::Rng;

fn affine(columns: [[f64; 3]; 3], origin: [f64; 3]) -> DAffine3 {
    let [x, y, z] = columns.map(DVec3::from_array);
    DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: DVec3::from_array(origin) }
}

/// Every way in which i, j, k can run along ±x, ±y, ±z; numbers that f32 holds exactly.
pub fn axis_orders() -> Vec<DAffine3> {
    let mut all = Vec::new();
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for signs in 0..8 {
            let mut columns = [[0.0; 3]; 3];
            for (a, column) in columns.iter_mut().enumerate() {
                let sign = if signs >> a & 1 == 1 { -1.0 } else { 1.0 };
                column[order[a]] = sign * [0.75, 1.125, 2.5][a];
            }
            all.push(affine(columns, [-12.25, 30.5, 7.0]));
        }
    }
    assert_eq!(all.len(), 48);
    all
}

pub fn oblique(seed: u64) -> DAffine3 {
    let mut random = random(seed);
    let mut r = || random.random_range(-1.0..1.0);
    let turn = DQuat::from_xyzw(r(), r(), r(), r()).normalize();
    let spacing = DVec3::new(0.4, 0.9765625, 3.1);
    let mut m = DMat3::from_quat(turn) * DMat3::from_diagonal(spacing);
    if seed % 2 == 1 {
        m.z_axis = -m.z_axis;
    }
    DAffine3 { matrix3: m, translation: DVec3::new(-101.3, 17.7, 1234.5) }
}

fn voxels() -> Voxels {
    noise(VoxelType::I16, 3 * 4 * 5, 9)
}

fn with_sform(a: &DAffine3) -> Nifti {
    let mut header = Nifti::new(VoxelType::I16, &[3, 4, 5], false);
    let (m, t) = (a.matrix3, a.translation);
    for r in 0..3 {
        header.f32s(280 + 16 * r, &[m.x_axis[r], m.y_axis[r], m.z_axis[r], t[r]].map(|v| v as f32));
    }
    header.i16(254, 1);
    header
}

fn open_nifti(folder: &tempfile::TempDir, header: &Nifti) -> Opened {
    io::open(keep(folder, "a.nii", &header.with(&voxels()))).unwrap()
}

fn near(a: &DAffine3, b: &DAffine3, tolerance: f64) -> bool {
    a.to_cols_array().iter().zip(b.to_cols_array()).all(|(x, y)| (x - y).abs() <= tolerance)
}

#[test]
fn an_sform_of_any_axis_order_comes_as_it_is_and_moves_no_voxel() {
    let folder = tempfile::tempdir().unwrap();
    for order in axis_orders() {
        let opened = open_nifti(&folder, &with_sform(&order));
        assert_eq!(opened.grid.world_from_index, order);
        assert_eq!(opened.grid.dims, [3, 4, 5]);
        assert!(opened.warnings.is_empty(), "{:?}", opened.warnings);
        assert_eq!(opened.source(0, 0, &|_| true).unwrap().read([0; 3], [3, 4, 5]).unwrap(), voxels());
    }
    for seed in 0..20 {
        // srow is f32: a relative 2⁻²⁴ of coordinates up to 1300.
        assert!(near(&open_nifti(&folder, &with_sform(&oblique(seed))).grid.world_from_index, &oblique(seed), 1e-4));
    }
}

/// nifti1.h, method 2, by turning each axis with the quaternion itself: v' = q v q*.
fn by_quaternion(b: f64, c: f64, d: f64, spacing: [f64; 3], qfac: f64, offset: [f64; 3]) -> DAffine3 {
    fn product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
        let (pv, qv) = (DVec3::new(p[1], p[2], p[3]), DVec3::new(q[1], q[2], q[3]));
        let v = p[0] * qv + q[0] * pv + pv.cross(qv);
        [p[0] * q[0] - pv.dot(qv), v.x, v.y, v.z]
    }
    let q = [(1.0 - b * b - c * c - d * d).max(0.0).sqrt(), b, c, d];
    let turn = |v: [f64; 3]| {
        let t = product(product(q, [0.0, v[0], v[1], v[2]]), [q[0], -q[1], -q[2], -q[3]]);
        [t[1], t[2], t[3]]
    };
    let columns = [[spacing[0], 0.0, 0.0], [0.0, spacing[1], 0.0], [0.0, 0.0, qfac * spacing[2]]];
    affine(columns.map(turn), offset)
}

fn with_qform(q: [f32; 3], spacing: [f32; 3], qfac: f32, offset: [f32; 3]) -> Nifti {
    let mut header = Nifti::new(VoxelType::I16, &[3, 4, 5], true);
    header.f32(76, qfac).f32s(80, &spacing).f32s(256, &q).f32s(268, &offset).i16(252, 1);
    header
}

#[test]
fn a_qform_turns_as_its_quaternion_does() {
    let folder = tempfile::tempdir().unwrap();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // Closed forms: no turn, half a turn about x, a quarter about z, mirrored k; qfac 0 counts as 1.
    let cases = [
        ([0.0, 0.0, 0.0], 1.0, [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]]),
        ([1.0, 0.0, 0.0], 1.0, [[2.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, -4.0]]),
        ([0.0, 0.0, half], 1.0, [[0.0, 2.0, 0.0], [-3.0, 0.0, 0.0], [0.0, 0.0, 4.0]]),
        ([0.0, 0.0, 0.0], -1.0, [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, -4.0]]),
        ([0.0, 0.0, 0.0], 0.0, [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]]),
    ];
    for (q, qfac, columns) in cases {
        let opened = open_nifti(&folder, &with_qform(q, [2.0, 3.0, 4.0], qfac, [5.0, 6.0, 7.0]));
        // √½ in f32 is off by 3e-8, once squared and doubled.
        assert!(near(&opened.grid.world_from_index, &affine(columns, [5.0, 6.0, 7.0]), 1e-6), "{q:?} {qfac}");
        let expected = by_quaternion(
            q[0].into(),
            q[1].into(),
            q[2].into(),
            [2.0, 3.0, 4.0],
            if qfac < 0.0 { -1.0 } else { 1.0 },
            [5.0, 6.0, 7.0],
        );
        assert!(near(&expected, &affine(columns, [5.0, 6.0, 7.0]), 1e-6), "the reference itself");
    }
    let mut random = random(3);
    for _ in 0..200 {
        let q: [f32; 3] = std::array::from_fn(|_| random.random_range(-0.57..0.57));
        let qfac = if random.random() { 1.0 } else { -1.0 };
        let opened = open_nifti(&folder, &with_qform(q, [0.5, 1.25, 3.0], qfac, [-8.5, 0.0, 1.0]));
        let [b, c, d] = q.map(f64::from);
        let expected = by_quaternion(b, c, d, [0.5, 1.25, 3.0], qfac.into(), [-8.5, 0.0, 1.0]);
        assert!(near(&opened.grid.world_from_index, &expected, 1e-12), "{q:?}");
    }
}

#[test]
fn sform_comes_before_qform_and_qform_before_pixdim() {
    let folder = tempfile::tempdir().unwrap();
    let s = affine([[0.0, 2.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 3.0]], [1.0, 2.0, 3.0]);
    let mut header = with_sform(&s);
    header.f32s(76, &[1.0, 4.0, 5.0, 6.0]).f32s(268, &[9.0, 8.0, 7.0]).i16(252, 1);
    assert_eq!(open_nifti(&folder, &header).grid.world_from_index, s);
    header.i16(254, 0);
    let q = affine([[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 6.0]], [9.0, 8.0, 7.0]);
    assert_eq!(open_nifti(&folder, &header).grid.world_from_index, q);
    header.i16(252, 0);
    let opened = open_nifti(&folder, &header);
    assert_eq!(opened.grid.world_from_index, DAffine3 { translation: DVec3::ZERO, ..q });
    assert!(opened.warnings[0].contains("orientation is unknown"));
}

#[test]
fn a_form_that_cannot_be_is_passed_over_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let q = affine([[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 6.0]], [9.0, 8.0, 7.0]);
    let good = affine([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
    for (at, bad) in [(280, f32::NAN), (280, 0.0), (300, f32::INFINITY), (292, f32::NEG_INFINITY)] {
        let mut header = with_sform(&good);
        header.f32s(76, &[1.0, 4.0, 5.0, 6.0]).f32s(268, &[9.0, 8.0, 7.0]).i16(252, 1).f32(at, bad);
        let opened = open_nifti(&folder, &header);
        assert_eq!(opened.grid.world_from_index, q, "{bad} at {at}");
        assert!(opened.warnings[0].starts_with("sform"), "{:?}", opened.warnings);
        header.f32(256, f32::NAN);
        let opened = open_nifti(&folder, &header);
        assert_eq!(opened.grid.world_from_index, DAffine3 { translation: DVec3::ZERO, ..q });
        assert!(opened.warnings.iter().any(|w| w.starts_with("qform")), "{:?}", opened.warnings);
        header.f32s(76, &[1.0, 0.0, f32::NAN, -6.0]);
        let opened = open_nifti(&folder, &header);
        assert_eq!(opened.grid.spacing(), DVec3::new(1.0, 1.0, 6.0));
        assert_eq!(opened.warnings.iter().filter(|w| w.starts_with("pixdim")).count(), 3);
    }
    // A quaternion longer than 1 is normalised: half a turn about y.
    let opened = open_nifti(&folder, &with_qform([0.0, 3.0, 0.0], [1.0; 3], 1.0, [0.0; 3]));
    assert!(near(&opened.grid.world_from_index, &DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0)), 1e-12));
    assert!(opened.warnings[0].contains("normalised"));
}

#[test]
fn metres_and_micrometres_become_millimetres() {
    let folder = tempfile::tempdir().unwrap();
    let s = affine([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], [1.0, 2.0, 3.0]);
    for (unit, factor) in [(0, 1.0), (1, 1000.0), (2, 1.0), (3, 0.001), (8 + 2, 1.0), (16 + 3, 0.001)] {
        let mut header = with_sform(&s);
        header.bytes[123] = unit;
        let expected = DAffine3 { matrix3: s.matrix3 * factor, translation: s.translation * factor };
        assert_eq!(open_nifti(&folder, &header).grid.world_from_index, expected);
        header.i16(254, 0).f32s(80, &[2.0; 3]);
        assert_eq!(open_nifti(&folder, &header).grid.spacing(), DVec3::splat(2.0 * factor));
        // A qform says the unit of its offset and of the spacings that it turns: a quarter turn about z, k the other way.
        let half = std::f32::consts::FRAC_1_SQRT_2;
        header.i16(252, 1).f32s(76, &[-1.0, 2.0, 3.0, 5.0]).f32s(256, &[0.0, 0.0, half, 7.0, -8.0, 9.0]);
        let turned = affine([[0.0, 2.0, 0.0], [-3.0, 0.0, 0.0], [0.0, 0.0, -5.0]], [7.0, -8.0, 9.0]);
        let expected = DAffine3 { matrix3: turned.matrix3 * factor, translation: turned.translation * factor };
        assert!(near(&open_nifti(&folder, &header).grid.world_from_index, &expected, 1e-6 * factor), "{unit}");
    }
}

#[test]
fn a_second_nifti_says_its_place_in_doubles() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..10 {
        for (unit, factor) in [(2, 1.0), (1, 1000.0), (3, 0.001)] {
            let place = oblique(seed);
            let mut header = Nifti::second(VoxelType::I16, &[3, 4, 5], seed % 3 == 0);
            header.i32(348, 2).i32(500, unit + 8);
            let (m, t) = (place.matrix3, place.translation);
            for r in 0..3 {
                header.f64s(400 + 32 * r, &[m.x_axis[r], m.y_axis[r], m.z_axis[r], t[r]]);
            }
            let expected = DAffine3 { matrix3: m * factor, translation: t * factor };
            assert_eq!(open_nifti(&folder, &header).grid.world_from_index, expected);
            // The same by its qform.
            let turn = m * DMat3::from_diagonal(DVec3::new(1.0 / 0.4, 1.0 / 0.9765625, 1.0 / 3.1));
            let qfac = turn.determinant().signum();
            let q = DQuat::from_mat3(&(turn * DMat3::from_diagonal(DVec3::new(1.0, 1.0, qfac))));
            let q = if q.w < 0.0 { -q } else { q };
            header.i32(348, 0).i32(344, 1).f64s(104, &[qfac, 0.4, 0.9765625, 3.1]);
            header.f64s(352, &[q.x, q.y, q.z, t.x, t.y, t.z]);
            let opened = open_nifti(&folder, &header);
            assert!(near(&opened.grid.world_from_index, &expected, 1e-9 * factor.max(1.0)), "{seed} {unit}");
            assert!(opened.warnings.is_empty(), "{:?}", opened.warnings);
        }
    }
}

fn open_nrrd(folder: &tempfile::TempDir, lines: &[&str]) -> Opened {
    let all = [&["type: short", "encoding: raw", "endian: little", "sizes: 3 4 5", "dimension: 3"], lines].concat();
    io::open(keep(folder, "a.nrrd", &nrrd(&all, &bytes_of(&voxels(), false)))).unwrap()
}

#[test]
fn every_space_of_nrrd_is_turned_to_ras() {
    let folder = tempfile::tempdir().unwrap();
    let spaces = [
        ("right-anterior-superior", [1.0, 1.0, 1.0]),
        ("RAS", [1.0, 1.0, 1.0]),
        ("left-anterior-superior", [-1.0, 1.0, 1.0]),
        ("LAS", [-1.0, 1.0, 1.0]),
        ("left-posterior-superior", [-1.0, -1.0, 1.0]),
        ("Left-Posterior-Superior", [-1.0, -1.0, 1.0]),
        ("LPS", [-1.0, -1.0, 1.0]),
    ];
    for (name, signs) in spaces {
        for order in axis_orders().into_iter().chain((0..10).map(oblique)) {
            let text = |v: DVec3| format!("({:?}, {:?},{:e})", v.x, v.y, v.z);
            let m = order.matrix3;
            let directions = [m.x_axis, m.y_axis, m.z_axis].map(text).join(" ");
            let opened = open_nrrd(
                &folder,
                &[
                    &format!("space: {name}"),
                    &format!("space directions: {directions}"),
                    &format!("space origin: {}", text(order.translation)),
                ],
            );
            let signs = DVec3::from_array(signs);
            let turned = |v: DVec3| (v * signs).to_array();
            let expected = affine([m.x_axis, m.y_axis, m.z_axis].map(turned), turned(order.translation));
            assert_eq!(opened.grid.world_from_index, expected, "{name}");
            assert_eq!(opened.source(0, 0, &|_| true).unwrap().read([0; 3], [3, 4, 5]).unwrap(), voxels());
        }
    }
}

#[test]
fn nrrd_without_a_space_has_its_spacings_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let opened = open_nrrd(&folder, &["spacings: 0.5 0.25 NaN", "units: \"mm\" \"um\" \"mm\""]);
    assert_eq!(opened.grid.world_from_index, DAffine3::from_scale(DVec3::new(0.5, 0.00025, 1.0)));
    assert!(opened.warnings.iter().any(|w| w.contains("orientation is unknown")));
    assert!(opened.warnings.iter().any(|w| w.contains("spacings of axis 2")));
    let opened = open_nrrd(&folder, &["space: LPS", "spacings: 0.5 2 3", "space origin: (1,2,3)"]);
    let expected = affine([[-0.5, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 3.0]], [-1.0, -2.0, 3.0]);
    assert_eq!(opened.grid.world_from_index, expected);
    for (space, x) in [("space: scanner-xyz", 1e-3), ("space: 3D-right-handed", 1e-3), ("space dimension: 3", -1e-3)] {
        let opened = open_nrrd(
            &folder,
            &[space, "space directions: (1,0,0) (0,2,0) (0,0,3)", "space units: \"um\" \"um\" \"um\""],
        );
        assert!(near(&opened.grid.world_from_index, &DAffine3::from_scale(DVec3::new(x, 2.0 * x, 3e-3)), 1e-15));
        assert_eq!(opened.warnings.len(), 1, "{:?}", opened.warnings);
    }
}
