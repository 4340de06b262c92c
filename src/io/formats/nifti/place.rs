//! Where a NIfTI volume lies: sform before qform before pixdim (nifti1.h, methods 3, 2, 1), in mm.
//!
//! A form that cannot be used (not finite, singular) is passed over with a warning, as the standard's own reader does.

use crate::io::formats::nifti::header::Header;
use crate::io::place::flaw;
use crate::math::{DAffine3, DMat3, DVec3};

/// RAS+ mm from index.
pub(crate) fn world_from_index(header: &Header, warnings: &mut Vec<String>) -> DAffine3 {
    let mm = mm_per_unit(header.xyzt_units, warnings);
    let scaled = |a: DAffine3| DAffine3 { matrix3: a.matrix3 * mm, translation: a.translation * mm };
    let (sform_code, qform_code) = (header.sform_code, header.qform_code);
    if sform_code > 0 {
        let sform = scaled(sform(header));
        match flaw(&sform) {
            None => return sform,
            Some(flaw) => warnings.push(format!("sform has {flaw}; passed over")),
        }
    }
    let spacing = spacing(header, warnings);
    if qform_code > 0 {
        let qform = qform(header, spacing, warnings).map(scaled).and_then(|a| match flaw(&a) {
            None => Ok(a),
            Some(flaw) => Err(flaw),
        });
        match qform {
            Ok(qform) => return qform,
            Err(flaw) => warnings.push(format!("qform has {flaw}; passed over")),
        }
    }
    warnings.push(
        "orientation is unknown (no usable sform or qform): i, j, k are taken as right, anterior, superior".into(),
    );
    let plain = |spacing| scaled(DAffine3 { matrix3: DMat3::from_diagonal(spacing), translation: DVec3::ZERO });
    let place = plain(spacing);
    match flaw(&place) {
        None => place,
        Some(flaw) => {
            warnings.push(format!("pixdim has {flaw}; taken as 1 mm"));
            DAffine3::IDENTITY
        }
    }
}

/// `xyzt_units`, its lowest three bits: 1 m, 2 mm, 3 µm; 0, unknown, is mm by custom.
fn mm_per_unit(xyzt_units: i32, warnings: &mut Vec<String>) -> f64 {
    match xyzt_units & 7 {
        0 | 2 => 1.0,
        1 => 1000.0,
        3 => 0.001,
        other => {
            warnings.push(format!("xyzt_units is {xyzt_units} with unit of space {other}; taken as mm"));
            1.0
        }
    }
}

/// `pixdim[1..=3]`, made positive; 1 where there is nothing sensible.
fn spacing(header: &Header, warnings: &mut Vec<String>) -> DVec3 {
    let rank = header.dim[0];
    let mut size = |a: usize, usual: f64| {
        let found = header.pixdim[a];
        // Axes that a picture does not have are left at 0 or 1: a picture is as thick as its pixels are wide.
        let left_out = a as i64 > rank && found == 1.0;
        let taken = if found.is_finite() && found != 0.0 && !left_out { found.abs() } else { usual };
        if taken != found && rank >= a as i64 {
            warnings.push(format!("pixdim[{a}] is {found}; taken as {taken}"));
        }
        taken
    };
    let x = size(1, 1.0);
    let y = size(2, if rank < 2 { x } else { 1.0 });
    DVec3::new(x, y, size(3, if rank < 3 { x.min(y) } else { 1.0 }))
}

/// Method 3: rows `srow_x`, `srow_y`, `srow_z`.
fn sform(header: &Header) -> DAffine3 {
    let column = |c: usize| DVec3::new(header.rows[0][c], header.rows[1][c], header.rows[2][c]);
    let (x, y, mut z) = (column(0), column(1), column(2));
    if header.dim[0] < 3 && z == DVec3::ZERO {
        // A picture's direction across may be left out.
        z = x.cross(y).normalize_or_zero() * x.length().min(y.length());
    }
    DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: column(3) }
}

/// Method 2: the quaternion's rotation, pixdim's spacing, `pixdim[0]` (qfac) the sign of k, `qoffset`.
fn qform(header: &Header, spacing: DVec3, warnings: &mut Vec<String>) -> Result<DAffine3, String> {
    let [mut b, mut c, mut d] = header.quaternion;
    let length2 = b * b + c * c + d * d;
    if !length2.is_finite() {
        return Err("a quaternion that is not finite".into());
    }
    // As nifti_quatern_to_mat44: close to a half turn a is 0 and (b, c, d) is normalised.
    let mut a = 1.0 - length2;
    if a < 1e-7 {
        // f32 rounding alone makes the length differ from 1 by no more than this.
        if length2 > 1.0 + 1e-4 {
            warnings.push(format!("quatern_b, c, d has length {}, more than 1; normalised", length2.sqrt()));
        }
        let scale = 1.0 / length2.sqrt();
        (b, c, d) = (b * scale, c * scale, d * scale);
        a = 0.0;
    } else {
        a = a.sqrt();
    }
    let rotation = DMat3::from_cols(
        DVec3::new(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
        DVec3::new(2.0 * (b * c - a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d + a * b)),
        DVec3::new(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a + d * d - c * c - b * b),
    );
    let qfac = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let offset = DVec3::from_array(header.offset);
    let scale = DVec3::new(spacing.x, spacing.y, qfac * spacing.z);
    Ok(DAffine3 { matrix3: rotation * DMat3::from_diagonal(scale), translation: offset })
}
