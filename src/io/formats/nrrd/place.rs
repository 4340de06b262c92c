//! Which axes of a NRRD file are space, frames and components, and where the space lies, in RAS+ mm.

use crate::io::error::IoError;
use crate::io::formats::nrrd::header::Header;
use crate::io::layout::{Axis, Role};
use crate::io::place::{dimension, grid};
use crate::math::{DAffine3, DMat3, DVec3};
use crate::volume::Grid;

/// The grid and what each axis counts, fastest first.
pub(crate) fn place(header: &Header, warnings: &mut Vec<String>) -> Result<(Grid, Vec<Axis>), IoError> {
    let sizes = header.sizes()?;
    let space = Space::new(header, warnings)?;
    let directions = match &space {
        Some(space) => space.directions(header)?,
        None if header.get("space directions").is_some() => {
            return Err(header.wrong("space", "", "the space that `space directions` are in"));
        }
        None => None,
    };
    let roles = roles(header, directions.as_deref(), warnings)?;
    let spacings = header.spacings()?;
    let axis_units = header.words_for("units", header.dimension)?;
    let mut columns: Vec<DVec3> = Vec::new();
    let mut dims = [1; 3];
    for (a, role) in roles.iter().enumerate() {
        let Role::Space(to) = *role else { continue };
        dims[to] = dimension(&header.file, "sizes", sizes[a])?;
        let column = match directions.as_ref().map(|d| d[a]) {
            Some(Some(v)) => v,
            _ => {
                let given = spacings.as_ref().and_then(|s| s[a]).filter(|&s| s != 0.0);
                if given.is_none() && spacings.is_some() {
                    warnings.push(format!("spacings of axis {a} is not a length; taken as 1"));
                }
                let mm = axis_units.as_ref().map_or(1.0, |u| mm_per_unit("units", &u[a], warnings));
                DVec3::AXES[to] * (given.unwrap_or(1.0) * if space.is_none() { mm } else { 1.0 })
            }
        };
        columns.push(column);
    }
    if directions.is_none() && spacings.is_none() {
        warnings.push("spacing is unknown (no `space directions`, no `spacings`): taken as 1 mm".into());
    }
    complete(&mut columns);
    let matrix3 = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let world_from_index = match &space {
        Some(space) => space.world_from(DAffine3 { matrix3, translation: space.origin(header)? }),
        None => {
            warnings.push("orientation is unknown (no `space`): axes are taken as right, anterior, superior".into());
            DAffine3 { matrix3, translation: DVec3::ZERO }
        }
    };
    let field = if directions.is_some() { "space directions" } else { "spacings" };
    let grid = grid(&header.file, field, dims, world_from_index)?;
    let axes = sizes.into_iter().zip(roles).map(|(len, role)| Axis { len, role }).collect();
    Ok((grid, axes))
}

/// Fills up to three directions for pictures with fewer axes: at right angles, as long as the shortest that there is.
fn complete(columns: &mut Vec<DVec3>) {
    let length = columns.iter().map(|c| c.length()).fold(f64::INFINITY, f64::min);
    let length = if length > 0.0 && length.is_finite() { length } else { 1.0 };
    if columns.len() == 2 {
        columns.push(columns[0].cross(columns[1]).try_normalize().unwrap_or(DVec3::Z) * length);
    }
    if let [only] = columns[..] {
        let others = only.try_normalize().map_or([DVec3::Y, DVec3::Z], |u| u.any_orthonormal_pair().into());
        columns.extend(others.map(|c| c * length));
    }
}

/// What each axis counts. With directions: those that have one are space. Without: `kinds` decide, else the first three are.
/// Another axis is frames if its kind is `time`, or if it comes last and its kind says nothing; else components.
fn roles(
    header: &Header,
    directions: Option<&[Option<DVec3>]>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Role>, IoError> {
    let n = header.dimension;
    let kinds: Vec<String> = match header.words_for("kinds", n)? {
        Some(kinds) => kinds.into_iter().map(|k| k.to_ascii_lowercase()).collect(),
        None => vec!["???".into(); n],
    };
    let silent = |a: usize| ["???", "none", "domain", "space"].contains(&kinds[a].as_str());
    let spatial: Vec<bool> = match directions {
        Some(d) => d.iter().map(Option::is_some).collect(),
        None => {
            let mut left = 3;
            let mut take = |a: usize| {
                let space = silent(a) && left > 0;
                left -= i32::from(space);
                space
            };
            (0..n).map(&mut take).collect()
        }
    };
    let count = spatial.iter().filter(|&&s| s).count();
    if !(1..=3).contains(&count) {
        let field = if directions.is_some() { "space directions" } else { "kinds" };
        return Err(header.wrong(field, format!("{count} axes of space"), "1 to 3"));
    }
    let mut next = 0;
    let mut role = |a: usize| {
        if spatial[a] {
            next += 1;
            Role::Space(next - 1)
        } else if kinds[a] == "time" {
            Role::Frame
        } else if silent(a) && a + 1 == n && next == count {
            warnings.push(format!("axis {a} is not space and has no kind: taken as frames"));
            Role::Frame
        } else {
            if silent(a) {
                warnings.push(format!("axis {a} has no direction and no kind: taken as components"));
            }
            Role::Component
        }
    };
    Ok((0..n).map(&mut role).collect())
}

/// The space that directions and origin are given in.
struct Space {
    /// Numbers per vector, 2 to 4; the fourth is time.
    dimension: usize,
    /// RAS from the space, one sign per axis.
    signs: DVec3,
    mm: DVec3,
}

impl Space {
    fn new(header: &Header, warnings: &mut Vec<String>) -> Result<Option<Self>, IoError> {
        let (dimension, signs) = if let Some(found) = header.get("space") {
            let name = found.to_ascii_lowercase();
            let plain = name.strip_suffix("-time");
            let (base, time) = match name.as_str() {
                "rast" | "last" | "lpst" => (&name[..3], true),
                _ => (plain.unwrap_or(&name), plain.is_some()),
            };
            let signs = match base {
                "right-anterior-superior" | "ras" => DVec3::ONE,
                "left-anterior-superior" | "las" => DVec3::new(-1.0, 1.0, 1.0),
                "left-posterior-superior" | "lps" => DVec3::new(-1.0, -1.0, 1.0),
                "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => {
                    warnings.push(format!(
                        "space {base} has no anatomical sides: x, y, z are taken as right, anterior, superior"
                    ));
                    DVec3::ONE
                }
                _ => {
                    let expected = "right-anterior-superior, left-anterior-superior, left-posterior-superior, scanner-xyz, \
                                    3D-right-handed or 3D-left-handed, with or without -time";
                    return Err(header.wrong("space", found, expected));
                }
            };
            (if time { 4 } else { 3 }, signs)
        } else if let Some(n) = header.number("space dimension")? {
            if !(2..=4).contains(&n) {
                return Err(header.wrong("space dimension", n, "2 to 4"));
            }
            // Such files come from ITK, for pictures and series: it means its own frame, and time as fourth.
            warnings.push("`space dimension` names no sides: x, y, z are taken as left, posterior, superior".into());
            (n as usize, DVec3::new(-1.0, -1.0, 1.0))
        } else {
            return Ok(None);
        };
        let mut mm = DVec3::ONE;
        if let Some(units) = header.words_for("space units", dimension)? {
            for a in 0..dimension.min(3) {
                mm[a] = mm_per_unit("space units", &units[a], warnings);
            }
        }
        Ok(Some(Self { dimension, signs, mm }))
    }

    /// Per axis of the file; `None` for those that are not space.
    fn directions(&self, header: &Header) -> Result<Option<Vec<Option<DVec3>>>, IoError> {
        let Some(vectors) = header.vectors("space directions", self.dimension)? else { return Ok(None) };
        if vectors.len() != header.dimension {
            let found = format!("{} entries", vectors.len());
            return Err(header.wrong("space directions", found, format!("{}, one per axis", header.dimension)));
        }
        let in_space = |v: Vec<f64>| {
            let along = point(&v);
            let time = v.get(3).is_some_and(|&t| t != 0.0);
            match (time, along == DVec3::ZERO) {
                (true, true) => Ok(None),
                (true, false) => Err(header.wrong("space directions", format!("{v:?}"), "space or time, not both")),
                (false, _) => Ok(Some(along)),
            }
        };
        vectors.into_iter().map(|v| v.map_or(Ok(None), in_space)).collect::<Result<_, _>>().map(Some)
    }

    fn origin(&self, header: &Header) -> Result<DVec3, IoError> {
        match header.vectors("space origin", self.dimension)?.as_deref() {
            None => Ok(DVec3::ZERO),
            Some([Some(v)]) => Ok(point(v)),
            Some(_) => {
                let found = header.get("space origin").unwrap_or_default();
                Err(header.wrong("space origin", found, format!("one vector of {} finite numbers", self.dimension)))
            }
        }
    }

    fn world_from(&self, space_from_index: DAffine3) -> DAffine3 {
        DAffine3::from_mat3(DMat3::from_diagonal(self.signs * self.mm)) * space_from_index
    }
}

/// A vector's part in space; a third number that is not there is 0.
fn point(vector: &[f64]) -> DVec3 {
    DVec3::new(vector[0], vector[1], vector.get(2).copied().unwrap_or(0.0))
}

fn mm_per_unit(field: &str, unit: &str, warnings: &mut Vec<String>) -> f64 {
    match unit.trim().to_lowercase().as_str() {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" | "" | "none" | "???" => 1.0,
        "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" | "micrometres" => {
            1e-3
        }
        "nm" | "nanometer" | "nanometers" | "nanometre" | "nanometres" => 1e-6,
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => 10.0,
        "m" | "meter" | "meters" | "metre" | "metres" => 1000.0,
        other => {
            warnings.push(format!("{field} \"{}\" is not known; taken as mm", crate::io::error::shown(other)));
            1.0
        }
    }
}
