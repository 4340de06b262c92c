//! Baking a sub-volume: what was edited in it, as far as its parent's voxels can hold it.
//!
//! A parent's voxel gets the mean of (edited − unedited) over its cell, from half a voxel before its centre to half a voxel after it, by
//! volume: a sample on a face of the cell counts half, on an edge a quarter, at a corner an eighth; what of the cell lies outside the box has
//! no edit. Labels go by the most of the cell. Voxels in whose cell nothing was edited stay bit for bit.

use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::scene::volumes::SubVolume;
use crate::document::state::State;
use crate::volume::{
    BRICK, Brick, BrickIndex, BrickKey, Field, FieldKey, FieldKind, SubBox, TexelFormat, Volume, VolumeId,
};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What a cell of the parent got, by channel: sums of weight times difference; of labels, weights by label.
#[derive(Clone, Debug, Default)]
struct Cell {
    added: [f64; 4],
    labels: BTreeMap<u16, f64>,
}

type Cells = BTreeMap<[u32; 3], Cell>;

/// Bakes a sub-volume into its parent.
pub(crate) fn bake(state: &mut State, id: VolumeId, edit: &mut Edit) -> Result<(), DocumentError> {
    let SubVolume { parent, of } = state.scene.sub_volume(id)?;
    for kind in FieldKind::ALL {
        let fine = state.at(Some(id))?.volume.clone();
        let cells = cells(&fine, kind, of)?;
        if cells.is_empty() {
            continue;
        }
        if kind == FieldKind::Density {
            make_room(state, parent, &cells, edit)?;
        }
        let coarse = state.at(Some(parent))?.volume.clone();
        let mut by_brick: BTreeMap<BrickIndex, Vec<([u32; 3], Cell)>> = BTreeMap::new();
        for (voxel, cell) in cells {
            by_brick.entry(BrickIndex::of_voxel(voxel)).or_default().push((voxel, cell));
        }
        let changes = by_brick.into_par_iter().map(|(index, cells)| {
            let brick = brick_with(&coarse, kind, index, &cells)?;
            Ok((index, Some(brick)))
        });
        let changes = changes.collect::<Result<Vec<_>, DocumentError>>()?;
        edit.swap(state, FieldKey::new(parent, kind), changes)?;
    }
    Ok(())
}

/// The share of a sample's volume in the cells of one axis that it lies in.
fn shares(sample: u32, scale: u32) -> [(i64, f64); 2] {
    // In halves of a sample's distance from the first voxel's centre.
    let (twice, whole) = (2 * i64::from(sample), 2 * i64::from(scale));
    let above = (twice + i64::from(scale)).div_euclid(whole);
    let on_face = (twice + i64::from(scale)).rem_euclid(whole) == 0;
    match on_face && scale > 1 {
        true => [(above - 1, 0.5), (above, 0.5)],
        false => [(above, 1.0), (above, 0.0)],
    }
}

/// What each cell of the parent got of a field, where anything in it was edited.
fn cells(fine: &Volume, kind: FieldKind, of: SubBox) -> Result<Cells, DocumentError> {
    let field = fine.field(kind);
    let whole: f64 = of.scale.iter().map(|&s| f64::from(s)).product();
    let of_brick = |index: BrickIndex| -> Result<Cells, DocumentError> {
        let (origin, valid, bytes) = (index.origin(), field.valid(0, index), field.format().bytes());
        let (now, was) = (field.brick(BrickKey { level: 0, index })?, field.base_brick(index)?);
        let own = (kind == FieldKind::Density).then(|| field.values(origin, valid)).transpose()?;
        let mut added: Vec<Option<f64>> = Vec::new();
        if let Some(values) = &own {
            added.resize(values.own.len(), None);
            for &(place, value) in &values.painted {
                added[place] = Some(value - values.unpainted(place).to_f64());
            }
        }
        let mut cells = Cells::new();
        let axes: [Vec<[(i64, f64); 2]>; 3] =
            std::array::from_fn(|a| (0..valid[a]).map(|i| shares(origin[a] + i, of.scale[a])).collect());
        let mut place = 0;
        for z in 0..valid[2] {
            for y in 0..valid[1] {
                for x in 0..valid[0] {
                    let at = [x, y, z];
                    let difference = difference(kind, &added, place, (&now, &was), at, bytes);
                    place += 1;
                    let Some((difference, label)) = difference else { continue };
                    for (i, wx) in axes[0][x as usize] {
                        for (j, wy) in axes[1][y as usize] {
                            for (k, wz) in axes[2][z as usize] {
                                let weight = wx * wy * wz / whole;
                                if weight == 0.0 {
                                    continue;
                                }
                                let voxel = [i, j, k].map(|v| v as u32);
                                let voxel = std::array::from_fn(|a| of.lo[a] + voxel[a]);
                                let cell = cells.entry(voxel).or_default();
                                (0..4).for_each(|c| cell.added[c] += weight * difference[c]);
                                if let Some(label) = label {
                                    *cell.labels.entry(label).or_default() += weight;
                                }
                            }
                        }
                    }
                }
            }
        }
        Ok(cells)
    };
    let edits: Vec<BrickIndex> = field.edits().into_keys().collect();
    let parts = edits.into_par_iter().map(of_brick).collect::<Result<Vec<_>, _>>()?;
    let mut all = Cells::new();
    for (voxel, cell) in parts.into_iter().flatten() {
        let into = all.entry(voxel).or_default();
        (0..4).for_each(|c| into.added[c] += cell.added[c]);
        cell.labels.into_iter().for_each(|(label, weight)| *into.labels.entry(label).or_default() += weight);
    }
    Ok(all)
}

/// What was added to a sample, by channel, and the label that it got; `None` where it was not edited. Colour by amounts of paint.
fn difference(
    kind: FieldKind,
    added: &[Option<f64>],
    place: usize,
    (now, was): (&Brick, &Brick),
    at: [u32; 3],
    bytes: usize,
) -> Option<([f64; 4], Option<u16>)> {
    if kind == FieldKind::Density {
        return added[place].map(|added| ([added, 0.0, 0.0, 0.0], None));
    }
    let (now, was) = (now.texel(at, bytes), was.texel(at, bytes));
    if now == was {
        return None;
    }
    Some(match kind {
        FieldKind::Colour => {
            let (now, was) = (amounts(now), amounts(was));
            (std::array::from_fn(|c| now[c] - was[c]), None)
        }
        FieldKind::Labels => ([0.0; 4], Some(u16::from_le_bytes([now[0], now[1]]))),
        _ => ([f64::from(now[0]) - f64::from(was[0]), 0.0, 0.0, 0.0], None),
    })
}

/// A colour multiplied by its alpha, 0 to 1.
fn amounts(texel: [u8; 4]) -> [f64; 4] {
    let [r, g, b, a] = texel.map(|c| f64::from(c) / 255.0);
    [r * a, g * a, b * a, a]
}

/// A brick of the parent with what its cells got.
fn brick_with(
    coarse: &Volume,
    kind: FieldKind,
    index: BrickIndex,
    cells: &[([u32; 3], Cell)],
) -> Result<Brick, DocumentError> {
    let field: &Field = coarse.field(kind);
    let bytes = field.format().bytes();
    let brick = field.brick(BrickKey { level: 0, index })?;
    let mut texels = brick.to_texels(bytes);
    for (voxel, cell) in cells {
        let at = voxel.map(|v| v % BRICK);
        let to = (at[0] + BRICK * (at[1] + BRICK * at[2])) as usize * bytes;
        let own = brick.texel(at, bytes);
        let new = match kind {
            FieldKind::Density => field.map().encode(field.number(*voxel)?.to_f64() + cell.added[0]),
            FieldKind::Selection => {
                let value = (f64::from(own[0]) + cell.added[0]).round().clamp(0.0, 255.0);
                [value as u8, 0, 0, 0]
            }
            FieldKind::Colour => {
                let own = amounts(own);
                let sum: [f64; 4] = std::array::from_fn(|c| (own[c] + cell.added[c]).clamp(0.0, 1.0));
                let alpha = sum[3];
                let channel = |c: f64| (255.0 * c).round() as u8;
                let straight = |c: usize| if alpha > 0.0 { channel((sum[c] / alpha).min(1.0)) } else { 0 };
                [straight(0), straight(1), straight(2), channel(alpha)]
            }
            FieldKind::Labels => {
                let of_voxel = u16::from_le_bytes([own[0], own[1]]);
                let others = cell.labels.iter().filter(|(label, _)| **label != of_voxel);
                let most = others.clone().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
                // What is not edited of a cell keeps its label.
                let keeps = 1.0 - others.map(|(_, weight)| weight).sum::<f64>();
                match most.filter(|(_, weight)| **weight > keeps) {
                    Some((label, _)) => {
                        let [a, b] = label.to_le_bytes();
                        [a, b, 0, 0]
                    }
                    None => own,
                }
            }
        };
        texels[to..to + bytes].copy_from_slice(&new[..bytes]);
    }
    Ok(Brick::from_texels(texels, bytes))
}

/// Gives the parent's density a map that holds what its voxels become.
fn make_room(state: &mut State, parent: VolumeId, cells: &Cells, edit: &mut Edit) -> Result<(), DocumentError> {
    let coarse = state.at(Some(parent))?.volume;
    let map = *coarse.density.map();
    let mut span: Option<[f64; 2]> = None;
    for (voxel, cell) in cells {
        let value = coarse.density.number(*voxel)?.to_f64() + cell.added[0];
        let [lo, hi] = span.unwrap_or([value; 2]);
        span = Some([lo.min(value), hi.max(value)]);
    }
    let Some([lo, hi]) = span.filter(|s| s.iter().all(|v| v.is_finite())) else { return Ok(()) };
    let fits = map.format == TexelFormat::R32Float || (map.lo <= lo && hi <= map.hi());
    if !fits {
        edit.remap(state, parent, map.in_floats())?;
    }
    if let Some(volume) = state.volumes.get_mut(&parent) {
        let [a, b] = volume.painted.unwrap_or([lo, hi]);
        volume.painted = Some([a.min(lo), b.max(hi)]);
    }
    Ok(())
}
