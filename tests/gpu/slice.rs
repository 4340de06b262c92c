//! Slices against a plain reference.

use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{FieldPools, Fields, Overlay, SliceCaster, SliceFrame, SliceLayer};
use burin::math::{DAffine3, DMat3, DVec2, DVec3};
use burin::volume::*;

/// Linear in the plane, the voxel itself across it, borders repeated.
fn bilinear(field: &Field, p: DVec3, value: impl Fn([u8; 4]) -> f64) -> f64 {
    let dims = field.dims(0);
    let mut sum = 0.0;
    for corner in 0..8 {
        let mut weight = 1.0;
        let voxel = std::array::from_fn(|a| {
            let (lo, t) = (p[a].floor(), p[a] - p[a].floor());
            weight *= if corner >> a & 1 == 1 { t } else { 1.0 - t };
            (lo as i64 + (corner >> a & 1)).clamp(0, i64::from(dims[a]) - 1) as u32
        });
        if weight > 0.0 {
            sum += weight * value(field.texel(voxel).unwrap());
        }
    }
    sum
}

struct Painted {
    grid: Grid,
    density: Field,
    colour: Field,
    selection: Field,
    labels: Field,
}

impl Painted {
    /// Smooth enough that the sampler's 8-bit weights cost less than half a grey level.
    fn new(world_from_index: DAffine3) -> Self {
        let grid = Grid { dims: [45, 38, 36], world_from_index };
        Self {
            density: density_u16(grid, |v| (v[0] * 40 + v[1] * 30 + v[2] * 20) as u16),
            colour: painted(FieldKind::Colour, &grid, |v| [200, 40, (v[0] * 3) as u8, if v[1] > 20 { 180 } else { 0 }]),
            selection: painted(FieldKind::Selection, &grid, |v| [(v[2] * 6) as u8, 0, 0, 0]),
            labels: painted(FieldKind::Labels, &grid, |v| [u8::from(v[0] > 30) + 2 * u8::from(v[1] < 7), 0, 0, 0]),
            grid,
        }
    }

    fn fields(&self) -> Fields<'_> {
        one_volume(&self.grid, &self.density, &self.colour, &self.selection, &self.labels)
    }
}

fn overlay(colour: f32, labels: f32, selection: f32) -> Overlay {
    let segment =
        |id, colour, visible| Segment { id, name: String::new(), colour, visible, locked: false, source_value: None };
    Overlay {
        colour,
        labels,
        selection,
        selection_colour: [0.0, 0.8, 0.4],
        segments: Segments(vec![segment(1, [0.9, 0.1, 0.2], true), segment(2, [0.0, 0.0, 1.0], false)]),
    }
}

fn reference(of: &Painted, frame: &SliceFrame, px: [u32; 2]) -> [f64; 4] {
    let own = &frame.own;
    let p = own.top_left + own.per_x * (f64::from(px[0]) + 0.5) + own.per_y * (f64::from(px[1]) + 0.5);
    if p.cmplt(DVec3::splat(-0.5)).any() || p.cmpge(of.grid.dims_f64() - 0.5).any() {
        return [0.0; 4];
    }
    let density = bilinear(&of.density, p, |t| of.density.map().decode(t));
    let [black, white] = own.window.unwrap();
    let grey = ((density - black) / (white - black)).clamp(0.0, 1.0);
    let mut c = [grey; 3];
    let mut mix = |with: [f64; 3], t: f64| {
        for (c, w) in c.iter_mut().zip(with) {
            *c += (w - *c) * t;
        }
    };
    let channel = |i: usize| bilinear(&of.colour, p, |t| f64::from(t[i]) / 255.0);
    mix([channel(0), channel(1), channel(2)], channel(3) * f64::from(own.overlay.colour));
    let voxel = (p + 0.5).floor().to_array().map(|v| v as u32);
    if of.labels.value(voxel).unwrap() == 1.0 {
        mix([0.9, 0.1, 0.2].map(|c: f64| (c * 255.0).round() / 255.0), f64::from(own.overlay.labels));
    }
    let s = bilinear(&of.selection, p, |t| f64::from(t[0]) / 255.0);
    mix(own.overlay.selection_colour.map(f64::from), s * f64::from(own.overlay.selection));
    [c[0], c[1], c[2], 1.0]
}

/// Compares whole pictures; within one grey level, pixels whose centre is within 1e-3 voxels of a voxel's border aside (labels).
fn compare(of: &Painted, frame: &SliceFrame) {
    let Some(gpu) = gpu() else { return };
    let mut pools = FieldPools::new(&gpu, &of.grid, &of.density, 64 << 20).unwrap();
    let mut caster = SliceCaster::new(&gpu).unwrap();
    let picture = caster.pixels(&gpu, &mut pools, &of.fields(), frame).unwrap();
    let (mut inside, mut largest, mut sum) = (0, 0.0_f64, 0.0);
    for (i, got) in picture.iter().enumerate() {
        let px = [i as u32 % frame.size[0], i as u32 / frame.size[0]];
        let expected = reference(of, frame, px);
        inside += usize::from(expected[3] > 0.0);
        let here = (0..4).map(|c| (f64::from(got[c]) - expected[c]).abs() * 255.0).fold(0.0, f64::max);
        (largest, sum) = (largest.max(here), sum + here);
        for c in 0..4 {
            assert!(
                (f64::from(got[c]) - expected[c]).abs() <= 1.0 / 255.0,
                "pixel {px:?} channel {c}: {got:?} for {expected:?}"
            );
        }
    }
    crate::common::oracle::tell(largest, sum / picture.len() as f64);
    assert!(inside > 500 && inside < picture.len(), "{inside} pixels of {}", picture.len());
}

/// A picture onto the slice `index` of `axis`, turned and shifted in the plane.
fn onto(of: &Painted, axis: usize, index: u32, overlay: Overlay) -> SliceFrame {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let world = |px: DVec2| {
        let mut p = DVec3::ZERO;
        p[axis] = f64::from(index);
        p[u] = -6.313 + 0.7317 * px.x;
        p[v] = 47.113 - 0.8119 * px.y;
        of.grid.world_from_index.transform_point3(p)
    };
    SliceFrame::new(&of.grid, (axis, index), [83, 71], world, (1200.0, 2100.0), overlay)
}

#[test]
fn slices_along_every_axis_equal_the_reference() {
    let of = Painted::new(DAffine3::IDENTITY);
    for (axis, index) in [(0, 0), (0, 32), (1, 31), (1, 37), (2, 7)] {
        compare(&of, &onto(&of, axis, index, overlay(0.0, 0.0, 0.0)));
        compare(&of, &onto(&of, axis, index, overlay(0.6, 0.5, 0.7)));
    }
}

#[test]
fn slices_of_oblique_anisotropic_grids_equal_the_reference() {
    let m =
        DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(-0.3) * DMat3::from_diagonal(DVec3::new(0.5, 1.5, -3.0));
    let of = Painted::new(DAffine3 { matrix3: m, translation: DVec3::new(-90.0, 20.0, 55.0) });
    for axis in 0..3 {
        compare(&of, &onto(&of, axis, 17, overlay(1.0, 1.0, 0.3)));
    }
}

#[test]
fn a_slice_shows_an_edit_voxel_by_voxel() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([40, 40, 40]);
    let density = density_u16(grid, |_| 100);
    let (colour, labels) = (Field::blank(FieldKind::Colour, &grid), Field::blank(FieldKind::Labels, &grid));
    let mut selection = Field::blank(FieldKind::Selection, &grid);
    let mut pools = FieldPools::new(&gpu, &grid, &density, 64 << 20).unwrap();
    let mut caster = SliceCaster::new(&gpu).unwrap();
    let overlay = Overlay { selection: 1.0, selection_colour: [1.0, 0.0, 0.0], ..Overlay::default() };
    let world = |px: DVec2| DVec3::new(px.x - 0.5, px.y - 0.5, 20.0);
    let frame = SliceFrame::new(&grid, (2, 20), [40, 40], world, (100.0, 400.0), overlay);
    let grey = [0.5, 0.5, 0.5, 1.0];
    let close = |a: [f32; 4], b: [f32; 4]| (0..4).all(|i| (a[i] - b[i]).abs() < 1e-3);
    {
        let fields = one_volume(&grid, &density, &colour, &selection, &labels);
        assert!(caster.pixels(&gpu, &mut pools, &fields, &frame).unwrap().iter().all(|p| close(*p, grey)));
    }
    // One voxel in the slice, one in its neighbour.
    let mut texels = vec![0; BRICK_VOXELS];
    let at = |v: [u32; 3]| (v[0] % 32 + 32 * (v[1] % 32 + 32 * (v[2] % 32))) as usize;
    texels[at([31, 5, 20])] = 255;
    texels[at([9, 9, 21])] = 255;
    let change = vec![(BrickIndex([0, 0, 0]), Some(Brick::from_texels(texels, 1)))];
    let (_, refresh) = selection.swap(change).unwrap();
    pools.refresh(&gpu, FieldKind::Selection, &selection, &refresh).unwrap();
    let fields = one_volume(&grid, &density, &colour, &selection, &labels);
    let picture = caster.pixels(&gpu, &mut pools, &fields, &frame).unwrap();
    for (i, p) in picture.iter().enumerate() {
        let expected = if i == 31 + 40 * 5 { [1.0, 0.0, 0.0, 1.0] } else { grey };
        assert!(close(*p, expected), "pixel {} {}: {p:?}", i % 40, i / 40);
    }
}

#[test]
fn other_volumes_lie_over_a_slice_each_on_its_own_grid() {
    let Some(gpu) = gpu() else { return };
    let of = Painted::new(DAffine3::IDENTITY);
    let turned =
        DMat3::from_rotation_z(0.3) * DMat3::from_rotation_y(0.2) * DMat3::from_diagonal(DVec3::new(1.3, 0.9, 2.0));
    let other = Painted::new(DAffine3 { matrix3: turned, translation: DVec3::new(5.0, -8.0, -6.0) });
    let (first, second) = (of.fields(), other.fields());
    let mut fields = Fields::default();
    fields.put(VolumeId(3), *first.get(VolumeId::FIRST).unwrap());
    fields.put(VolumeId(8), *second.get(VolumeId::FIRST).unwrap());
    let mut pools = FieldPools::empty(&gpu, 64 << 20).unwrap();
    let mut caster = SliceCaster::new(&gpu).unwrap();
    for (axis, grey) in [(0, Some((900.0, 1500.0))), (1, None), (2, Some((1300.0, 2600.0)))] {
        let mut frame = onto(&of, axis, 12, overlay(0.0, 0.5, 0.0));
        frame.own.volume = VolumeId(3);
        let base = frame.clone();
        let world = |px: DVec2| {
            let p = base.own.top_left + base.own.per_x * px.x + base.own.per_y * px.y;
            of.grid.world_from_index.transform_point3(p)
        };
        let layer = |grey, opacity, overlay| {
            SliceLayer::new((VolumeId(8), &other.grid), frame.size, world, grey, opacity, overlay)
        };
        let above = layer(grey, 0.6, overlay(0.4, 0.7, 0.5));
        let below = layer(Some((1000.0, 2000.0)), 0.8, overlay(0.0, 0.0, 0.3));
        (frame.under, frame.over, frame.own.opacity) = (vec![below], vec![above], 0.7);
        let picture = caster.pixels(&gpu, &mut pools, &fields, &frame).unwrap();
        let (mut both, mut off) = (0, 0);
        for (i, got) in picture.iter().enumerate() {
            let px = [i as u32 % frame.size[0], i as u32 / frame.size[0]];
            let own = reference(&of, &base, px).map(|c| c * 0.7);
            let at = world(DVec2::new(f64::from(px[0]) + 0.5, f64::from(px[1]) + 0.5));
            let there = other.grid.index_from_world().transform_point3(at);
            let [under, over] = [&frame.under[0], &frame.over[0]].map(|layer| laid_over(&other, layer, there));
            both += usize::from(own[3] > 0.0 && over[3] > 0.0);
            let lay = |over: [f64; 4], under: [f64; 4]| std::array::from_fn(|c| over[c] + under[c] * (1.0 - over[3]));
            let expected: [f64; 4] = lay(over, lay(own, under));
            // At a voxel's border a label may be its neighbour's.
            off += usize::from((0..4).any(|c| (f64::from(got[c]) - expected[c]).abs() > 1.5 / 255.0));
        }
        assert!(both > 500 && off * 200 < picture.len(), "axis {axis}: {off} of {} off, {both} in both", picture.len());
        // A part of the picture is that part.
        let part = caster.pixels(&gpu, &mut pools, &fields, &frame.part([20, 30], [9, 5])).unwrap();
        let same = |i: usize| picture[20 + i % 9 + (30 + i / 9) * frame.size[0] as usize];
        assert!((0..45).all(|i| (0..4).all(|c| (part[i][c] - same(i)[c]).abs() < 2e-3)));
    }
}

/// A layer at a place of its grid, colours multiplied by opacity.
fn laid_over(of: &Painted, layer: &SliceLayer, p: DVec3) -> [f64; 4] {
    if p.cmplt(DVec3::splat(-0.5)).any() || p.cmpge(of.grid.dims_f64() - 0.5).any() {
        return [0.0; 4];
    }
    let at = p.as_vec3().to_array();
    let mut c = [0.0; 4];
    if let Some([black, white]) = layer.window {
        let density = trilinear(&of.density, 0, at, |t| of.density.map().decode(t));
        let grey = ((density - black) / (white - black)).clamp(0.0, 1.0);
        c = [grey, grey, grey, 1.0];
    }
    let mut lay = |with: [f64; 3], t: f64| {
        for (c, w) in c.iter_mut().zip([with[0], with[1], with[2], 1.0]) {
            *c += (w - *c) * t;
        }
    };
    let channel = |i: usize| trilinear(&of.colour, 0, at, |t| f64::from(t[i]) / 255.0);
    lay([channel(0), channel(1), channel(2)], channel(3) * f64::from(layer.overlay.colour));
    let voxel = (p + 0.5).floor().to_array().map(|v| v as u32);
    if of.labels.value(voxel).unwrap() == 1.0 {
        lay([0.9, 0.1, 0.2], f64::from(layer.overlay.labels));
    }
    let s = trilinear(&of.selection, 0, at, |t| f64::from(t[0]) / 255.0);
    lay(layer.overlay.selection_colour.map(f64::from), s * f64::from(layer.overlay.selection));
    c.map(|c| c * f64::from(layer.opacity))
}
