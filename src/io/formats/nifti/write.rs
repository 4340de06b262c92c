//! The header of a NIfTI: version 1, or 2 where an axis is too long for it.
//!
//! The place is said twice: by the sform, and by the qform where the axes stand at right angles; whichever a program asks first, it
//! finds the same. Millimetres, or another of NIfTI's units where only that one keeps 32-bit numbers exact, as files in micrometres
//! do. The source's slope and intercept are kept where they fit.

use crate::io::leaving::{Compression, Format, Leaving};
use crate::math::{DAffine3, DMat3, DQuat, DVec3};
use crate::volume::{FieldKind, Grid, VoxelType};

/// What fields leave in.
pub(crate) const FORMATS: [Format; 1] = [Format {
    name: "NIfTI (.nii.gz)",
    about: "FSL, FreeSurfer, ITK-SNAP, nibabel read it",
    endings: &[".nii.gz", ".nii"],
    compression: |ending| Some(if ending == ".nii" { Compression::Raw } else { Compression::Gzip }),
    labels_only: false,
    keeps,
    header,
}];

/// `NIFTI_XFORM_SCANNER_ANAT`: where the voxels lie in the patient.
const SCANNER: i16 = 1;
/// `NIFTI_INTENT_LABEL`.
const LABEL: i16 = 1002;
/// The longest axis of version 1.
const LONGEST: u32 = i16::MAX as u32;
/// How far axes may be from a right angle, as a cosine, for a quaternion to say them.
const SQUARE: f64 = 1e-6;

/// Whether the header holds these numbers as they are.
pub(crate) fn keeps((slope, intercept): (f64, f64)) -> bool {
    let exact = |x: f64| f64::from(x as f32) == x;
    slope != 0.0 && exact(slope) && exact(intercept)
}

/// All bytes before the voxels.
pub(crate) fn header(leaving: &Leaving<'_>, _: Compression) -> Vec<u8> {
    let Leaving { field, grid, voxel_type, width, scaling: (slope, intercept), .. } = *leaving;
    let (datatype, bits) = match (width, code(voxel_type)) {
        (4, _) => (2304, 32),
        (_, code) => (code, voxel_type.bytes() as i16 * 8),
    };
    let place = Place::new(grid);
    let dims: Vec<i64> = [3].into_iter().chain(grid.dims.map(i64::from)).chain([1; 4]).collect();
    let intent = if field.kind() == FieldKind::Labels { LABEL } else { 0 };
    let said = format!("Burin: {}", field.kind().name());
    if grid.dims.iter().any(|&n| n > LONGEST) {
        let mut out = Bytes(vec![0; 544]);
        out.put(0, &540_i32.to_le_bytes());
        out.put(4, b"n+2\0\r\n\x1a\n");
        out.put(12, &datatype.to_le_bytes());
        out.put(14, &bits.to_le_bytes());
        dims.iter().enumerate().for_each(|(a, n)| out.put(16 + 8 * a, &n.to_le_bytes()));
        out.f64s(104, &place.pixdim);
        out.put(168, &544_i64.to_le_bytes());
        out.f64s(176, &[slope, intercept]);
        out.put(240, said.as_bytes());
        out.put(344, &i32::from(place.qform_code).to_le_bytes());
        out.put(348, &i32::from(SCANNER).to_le_bytes());
        out.f64s(352, &place.quaternion);
        out.f64s(376, &place.offset);
        out.f64s(400, place.rows.as_flattened());
        out.put(500, &i32::from(place.unit).to_le_bytes());
        out.put(504, &i32::from(intent).to_le_bytes());
        return out.0;
    }
    let mut out = Bytes(vec![0; 352]);
    out.put(0, &348_i32.to_le_bytes());
    // What Analyze 7.5 wants to see here.
    out.put(38, b"r");
    dims.iter().enumerate().for_each(|(a, &n)| out.put(40 + 2 * a, &(n as i16).to_le_bytes()));
    out.put(68, &intent.to_le_bytes());
    out.put(70, &datatype.to_le_bytes());
    out.put(72, &bits.to_le_bytes());
    out.f32s(76, &place.pixdim);
    out.f32s(108, &[352.0, slope, intercept]);
    out.put(123, &[place.unit]);
    out.put(148, said.as_bytes());
    out.put(252, &place.qform_code.to_le_bytes());
    out.put(254, &SCANNER.to_le_bytes());
    out.f32s(256, &place.quaternion);
    out.f32s(268, &place.offset);
    out.f32s(280, place.rows.as_flattened());
    out.put(344, b"n+1\0");
    out.0
}

/// As nifti1.h numbers them.
fn code(voxel_type: VoxelType) -> i16 {
    match voxel_type {
        VoxelType::U8 => 2,
        VoxelType::I16 => 4,
        VoxelType::I32 => 8,
        VoxelType::F32 => 16,
        VoxelType::F64 => 64,
        VoxelType::I8 => 256,
        VoxelType::U16 => 512,
        VoxelType::U32 => 768,
        VoxelType::I64 => 1024,
        VoxelType::U64 => 1280,
    }
}

struct Bytes(Vec<u8>);

impl Bytes {
    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn f32s(&mut self, at: usize, numbers: &[f64]) {
        numbers.iter().enumerate().for_each(|(i, &x)| self.put(at + 4 * i, &(x as f32).to_le_bytes()));
    }

    fn f64s(&mut self, at: usize, numbers: &[f64]) {
        numbers.iter().enumerate().for_each(|(i, &x)| self.put(at + 8 * i, &x.to_le_bytes()));
    }
}

/// A grid's place in the header's numbers.
struct Place {
    /// `xyzt_units`.
    unit: u8,
    rows: [[f64; 4]; 3],
    /// 0 where the axes stand askew: then only the sform says the place.
    qform_code: i16,
    quaternion: [f64; 3],
    offset: [f64; 3],
    pixdim: [f64; 8],
}

impl Place {
    fn new(grid: &Grid) -> Self {
        let scaled = |per_mm: f64| DAffine3 {
            matrix3: grid.world_from_index.matrix3 * per_mm,
            translation: grid.world_from_index.translation * per_mm,
        };
        // Millimetres, micrometres, metres.
        let units = [(2, 1.0), (3, 1000.0), (1, 0.001)];
        let (unit, per_mm) = units.into_iter().find(|&(_, f)| is_exact(&scaled(f))).unwrap_or(units[0]);
        let DAffine3 { matrix3: m, translation: t } = scaled(per_mm);
        let spacing = grid.spacing() * per_mm;
        let turn = DMat3::from_cols(m.x_axis / spacing.x, m.y_axis / spacing.y, m.z_axis / spacing.z);
        let square = turn.x_axis.dot(turn.y_axis).abs() < SQUARE
            && turn.y_axis.dot(turn.z_axis).abs() < SQUARE
            && turn.z_axis.dot(turn.x_axis).abs() < SQUARE;
        let qfac = if turn.determinant() < 0.0 { -1.0 } else { 1.0 };
        let q = DQuat::from_mat3(&(turn * DMat3::from_diagonal(DVec3::new(1.0, 1.0, qfac)))).normalize();
        // The real part is left out of the header and taken as positive.
        let q = if q.w < 0.0 { -q } else { q };
        Self {
            unit,
            rows: std::array::from_fn(|r| [m.x_axis[r], m.y_axis[r], m.z_axis[r], t[r]]),
            qform_code: if square { SCANNER } else { 0 },
            quaternion: if square { [q.x, q.y, q.z] } else { [0.0; 3] },
            offset: t.to_array(),
            pixdim: [qfac, spacing.x, spacing.y, spacing.z, 1.0, 1.0, 1.0, 1.0],
        }
    }
}

/// Whether 32-bit numbers hold an affine, but for what a change of unit rounds.
fn is_exact(affine: &DAffine3) -> bool {
    affine.to_cols_array().iter().all(|&x| (f64::from(x as f32) - x).abs() <= x.abs() * 1e-15)
}
