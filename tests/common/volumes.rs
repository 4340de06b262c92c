//! Synthetic volumes.

use burin::gpu::{Body, Fields, Frame, Mask, Matter, Overlay, Showing, VisibleValues, VolumeFields};
use burin::math::{Camera, DVec3};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use std::sync::Arc;

/// A source in memory that asks before each read whether it may, told where it begins and how many voxels it takes.
pub struct Watched<F>(pub MemorySource, pub F);

impl<F> std::fmt::Debug for Watched<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Watched").field(&self.0).finish()
    }
}

impl<F: Fn([u32; 3], [u32; 3]) -> Result<(), SourceError> + Send + Sync> BrickSource for Watched<F> {
    fn grid(&self) -> &Grid {
        self.0.grid()
    }
    fn voxel_type(&self) -> VoxelType {
        self.0.voxel_type()
    }
    fn scaling(&self) -> (f64, f64) {
        self.0.scaling()
    }
    fn name(&self) -> &str {
        self.0.name()
    }
    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        (self.1)(lo, size)?;
        self.0.read(lo, size)
    }
}

/// A grid with unit spacing, voxel (0, 0, 0) at the origin.
pub fn unit_grid(dims: [u32; 3]) -> Grid {
    Grid::aligned(dims, DVec3::ONE, DVec3::ZERO)
}

/// The fields of one volume.
pub fn one_volume<'a>(
    grid: &Grid,
    density: &'a Field,
    colour: &'a Field,
    selection: &'a Field,
    labels: &'a Field,
) -> Fields<'a> {
    Fields::one(VolumeFields { grid: *grid, density, colour, selection, labels })
}

/// A density field of `f` at every voxel, as u16 voxels mapped one to one.
pub fn density_u16(grid: Grid, f: impl Fn([u32; 3]) -> u16) -> Field {
    let voxels = Voxels::U16(each(grid.dims, f));
    let source = MemorySource::new("synthetic", grid, voxels, (1.0, 0.0)).unwrap();
    Field::from_source(Arc::new(source), DensityMap::codes(0.0, 65_535.0, Some(1.0)), &|_| true).unwrap().unwrap()
}

/// The same as 32-bit floats.
pub fn density_f32(grid: Grid, f: impl Fn([u32; 3]) -> f32) -> Field {
    let voxels = Voxels::F32(each(grid.dims, f));
    let source = MemorySource::new("synthetic", grid, voxels, (1.0, 0.0)).unwrap();
    Field::from_source(Arc::new(source), DensityMap::FLOAT, &|_| true).unwrap().unwrap()
}

/// `f` at every voxel, x fastest.
pub fn each<T>([nx, ny, nz]: [u32; 3], f: impl FnMut([u32; 3]) -> T) -> Vec<T> {
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).map(f).collect()
}

/// Paints a field as a whole: `f` gives the texel of every voxel.
pub fn painted(kind: FieldKind, grid: &Grid, f: impl Fn([u32; 3]) -> [u8; 4]) -> Field {
    let mut field = Field::blank(kind, grid);
    let bytes = field.format().bytes();
    let changes = field
        .brick_indices(0)
        .into_iter()
        .map(|index| {
            let o = index.origin();
            let texels = each([BRICK; 3], |v| f(std::array::from_fn(|a| o[a] + v[a])));
            let texels = texels.iter().flat_map(|t| t[..bytes].to_vec()).collect();
            (index, Some(Brick::from_texels(texels, bytes)))
        })
        .collect();
    field.swap(changes).unwrap();
    field
}

/// A transfer function whose opacity rises from `from` to `to`.
pub fn ramp(from: f64, to: f64) -> TransferFunction {
    TransferFunction {
        colour: vec![(from, [0.2, 0.1, 0.1]), (to, [1.0, 0.9, 0.8])],
        opacity: vec![(from, 0.0), (to, 0.5)],
        unit_mm: 1.0,
    }
}

/// One body, all of the volume, seen from `direction`.
pub fn frame(grid: &Grid, transfer: TransferFunction, direction: DVec3, size: [u32; 2]) -> Frame {
    Frame {
        camera: Camera::framing(&grid.world_bounds(), direction, DVec3::Z),
        size,
        step_mm: 1.0,
        refine: false,
        mode: Mode::Dvr,
        lighting: None,
        transfer,
        bodies: vec![Body::whole(0)],
        overlay: Overlay::default(),
        layers: Default::default(),
        looks: Vec::new(),
        overlays: Default::default(),
        boxes: Vec::new(),
        focus: None,
    }
}

/// What a body of a mask shows of the first volume.
pub fn matter(frame: &Frame, mask: Mask) -> Matter {
    Matter { volume: VolumeId::FIRST, values: Showing::One(VisibleValues::of(&frame.transfer, frame.mode)), mask }
}

/// Linear interpolation of a level's texels at a place in level-0 voxels, taps clamped to the volume.
pub fn trilinear(field: &Field, level: u8, p: [f32; 3], value: impl Fn([u8; 4]) -> f64) -> f64 {
    let bytes = field.format().bytes();
    let f = f64::from(1_u32 << level);
    let q: [f64; 3] = std::array::from_fn(|a| (f64::from(p[a]) + 0.5) / f - 0.5);
    let lo = q.map(|x| x.floor() as i64);
    let taps = field.read(level, lo, [2; 3]).unwrap();
    (0..8)
        .map(|i| {
            let mut texel = [0; 4];
            texel[..bytes].copy_from_slice(&taps[i * bytes..(i + 1) * bytes]);
            let weight: f64 = (0..3)
                .map(|a| {
                    let t = q[a] - lo[a] as f64;
                    if i >> a & 1 == 1 { t } else { 1.0 - t }
                })
                .product();
            if weight == 0.0 { 0.0 } else { weight * value(texel) }
        })
        .sum()
}

/// Seeded places: anywhere in the box, and on brick borders, volume faces and corners.
pub fn places(dims: [u32; 3], count: usize) -> Vec<[f32; 3]> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut out: Vec<[f32; 3]> = (0..count)
        .map(|i| {
            std::array::from_fn(|a| {
                let n = dims[a] as f32;
                match (i + a) % 3 {
                    0 => ((rng.random_range(0..=dims[a] / 32) * 32) as f32 - 0.5).min(n - 0.5),
                    _ => rng.random_range(-0.5..n - 0.5),
                }
            })
        })
        .collect();
    for i in 0..8 {
        out.push(std::array::from_fn(|a| if i >> a & 1 == 1 { dims[a] as f32 - 0.501 } else { -0.5 }));
    }
    out
}
