//! The volumes that are measured: the head as the other programs' benchmarks draw it, and cubes.

use burin::gpu::{Body, Fields, Frame, Overlay, VolumeFields};
use burin::math::{Aabb, Camera, DVec3, Plane, Pose, Projection};
use burin::volume::{
    DensityMap, Field, FieldKind, Grid, Lighting, MemorySource, Mode, TransferFunction, Value, Voxels,
};
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

pub type Failure = Box<dyn std::error::Error>;

/// Four fields of one volume.
pub struct Volume {
    pub grid: Grid,
    pub density: Field,
    pub colour: Field,
    pub selection: Field,
    pub labels: Field,
}

impl Volume {
    /// Of voxels of 1 mm, the first at the origin.
    pub fn new(dims: [u32; 3], voxels: Voxels, max: f64) -> Result<Self, Failure> {
        Self::on(Grid::aligned(dims, DVec3::ONE, DVec3::ZERO), voxels, max)
    }

    /// Of whole numbers from 0 to `max`; nothing is painted.
    pub fn on(grid: Grid, voxels: Voxels, max: f64) -> Result<Self, Failure> {
        let source = Arc::new(MemorySource::new("bench", grid, voxels, (1.0, 0.0))?);
        let map = DensityMap::codes(0.0, max, Some(1.0));
        let density = Field::from_source(source, map, &|_| true)?.ok_or("stopped")?;
        let blank = |kind| Field::blank(kind, &grid);
        Ok(Self {
            grid,
            density,
            colour: blank(FieldKind::Colour),
            selection: blank(FieldKind::Selection),
            labels: blank(FieldKind::Labels),
        })
    }

    /// As the only volume.
    pub fn fields(&self) -> Fields<'_> {
        Fields::one(self.volume_fields())
    }

    /// As one of several.
    pub fn volume_fields(&self) -> VolumeFields<'_> {
        let Self { grid, density, colour, selection, labels } = self;
        VolumeFields { grid: *grid, density, colour, selection, labels }
    }
}

/// Colin27 resampled to 256×256×166 with its first and last voxels kept in place, scaled to 0..254.
pub fn head() -> Result<Volume, Failure> {
    let voxels = resampled(HEAD, 254.0, |value| value as u8)?;
    Volume::new(HEAD, u8::wrap(voxels), 254.0)
}

/// The same values in so many voxels, x fastest.
pub fn head_values(dims: [u32; 3]) -> Result<Vec<u8>, Failure> {
    resampled(dims, 254.0, |value| value as u8)
}

/// The dims of the head as the other programs draw it.
const HEAD: [u32; 3] = [256, 256, 166];

/// The same in 512³ voxels of 16 bits: what a card is measured by.
pub fn large() -> Result<Volume, Failure> {
    let voxels = resampled([512; 3], 65_024.0, |value| value as u16)?;
    Volume::new([512; 3], u16::wrap(voxels), 65_024.0)
}

/// The folder with the assets: the repository, or what `BURIN_ROOT` says where the benches were carried elsewhere.
pub fn root() -> PathBuf {
    std::env::var_os("BURIN_ROOT").map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from)
}

/// The two voxels along an axis that a place lies between, and how near to the second.
type Tap = (usize, usize, f64);

/// Colin27 between its voxels, its first and last ones kept in place, scaled to 0..`most`, x fastest.
fn resampled<T: Send>(to: [u32; 3], most: f64, code: impl Fn(f64) -> T + Sync) -> Result<Vec<T>, Failure> {
    let source = burin::io::open(root().join("assets/ch2.nii.gz"))?.source(0, 0, &|_| true)?;
    let from = source.grid().dims;
    let all = source.read([0; 3], from)?;
    let values: Vec<f64> = (0..all.len()).map(|i| all.get(i)).collect();
    let max = values.iter().copied().fold(1.0, f64::max);
    let taps = |a: usize| -> Vec<Tap> {
        (0..to[a])
            .map(|i| {
                let p = f64::from(i) * f64::from(from[a] - 1) / f64::from(to[a] - 1);
                let low = (p.floor() as usize).min(from[a] as usize - 2);
                (low, low + 1, p - low as f64)
            })
            .collect()
    };
    let (xs, ys, zs) = (taps(0), taps(1), taps(2));
    let at = |x: usize, y: usize, z: usize| values[x + from[0] as usize * (y + from[1] as usize * z)];
    let value = |(x0, x1, fx): Tap, (y0, y1, fy): Tap, (z0, z1, fz): Tap| {
        let row = |y: usize, z: usize| at(x0, y, z) * (1.0 - fx) + at(x1, y, z) * fx;
        let low = row(y0, z0) * (1.0 - fy) + row(y1, z0) * fy;
        let high = row(y0, z1) * (1.0 - fy) + row(y1, z1) * fy;
        code(((low * (1.0 - fz) + high * fz) * (most / max)).clamp(0.0, most))
    };
    let (xs, ys, value) = (&xs, &ys, &value);
    let slice = |&z: &Tap| ys.iter().flat_map(move |&y| xs.iter().map(move |&x| value(x, y, z)));
    Ok(zs.par_iter().flat_map_iter(slice).collect())
}

/// The transfer function of the other programs' benchmarks.
pub fn transfer() -> TransferFunction {
    TransferFunction {
        colour: vec![(0.0, [0.0; 3]), (60.0, [0.55, 0.25, 0.15]), (120.0, [0.9, 0.7, 0.5]), (255.0, [1.0; 3])],
        opacity: vec![(0.0, 0.0), (30.0, 0.0), (200.0, 0.15), (255.0, 0.3)],
        unit_mm: 1.0,
    }
}

/// VTK's azimuth (about the view's up) and elevation (about its right), in degrees, about the target.
fn turned(camera: &Camera, azimuth: f64, elevation: f64) -> Camera {
    use burin::math::DQuat;
    let (right, _) = camera.right_up();
    let eye = DQuat::from_axis_angle(camera.up, azimuth.to_radians()) * (camera.eye - camera.target);
    let right = DQuat::from_axis_angle(camera.up, azimuth.to_radians()) * right;
    let eye = DQuat::from_axis_angle(right, -elevation.to_radians()) * eye;
    Camera { eye: camera.target + eye, ..*camera }
}

/// The camera of frame `i`: 7.3 degrees further every time, so that nothing can be cached.
pub fn camera(centre: DVec3, distance: f64, i: usize) -> Camera {
    let front = Camera {
        eye: centre - DVec3::Y * distance,
        target: centre,
        up: DVec3::Z,
        projection: Projection::Perspective { fov_y_deg: 30.0 },
    };
    turned(&turned(&front, 30.0, 20.0), 7.3 * i as f64, 0.0)
}

/// A frame as the other programs draw the head, a sample a voxel.
pub fn frame(camera: Camera, mode: Mode, shaded: bool, bodies: Vec<Body>) -> Frame {
    Frame {
        camera,
        size: [512; 2],
        step_mm: 1.0,
        refine: false,
        mode,
        lighting: shaded.then(Lighting::default),
        transfer: transfer(),
        bodies,
        overlay: Overlay::default(),
        layers: Default::default(),
        looks: Vec::new(),
        overlays: Default::default(),
        boxes: Vec::new(),
        focus: None,
    }
}

/// The head cut into 1 to 64 blocks, each moved out by `share` of its centre's offset and turned `degrees` about z.
pub fn blocks(n: usize, share: f64, degrees: f64) -> Vec<Body> {
    let split: [usize; 3] = match n {
        1 => [1, 1, 1],
        2 => [2, 1, 1],
        4 => [2, 2, 1],
        8 => [2, 2, 2],
        16 => [4, 2, 2],
        32 => [4, 4, 2],
        _ => [4, 4, 4],
    };
    let dims = [256.0, 256.0, 166.0];
    let centre = DVec3::new(127.5, 127.5, 82.5);
    let edge = |a: usize, i: usize| ((dims[a] - 1.0) * i as f64 / split[a] as f64).round_ties_even();
    let mut bodies = Vec::new();
    for z in 0..split[2] {
        for y in 0..split[1] {
            for x in 0..split[0] {
                let at = [x, y, z];
                let min = DVec3::from_array(std::array::from_fn(|a| edge(a, at[a])));
                let max = DVec3::from_array(std::array::from_fn(|a| edge(a, at[a] + 1)));
                // The outer faces are the volume's own, half a voxel beyond its last centres.
                let planes: Vec<Plane> = Aabb { min, max }
                    .planes()
                    .into_iter()
                    .enumerate()
                    .filter(|(i, _)| if i % 2 == 0 { at[i / 2] > 0 } else { at[i / 2] + 1 < split[i / 2] })
                    .map(|(_, p)| p)
                    .collect();
                let middle = (min + max) * 0.5;
                let turn = (degrees * (middle.x - centre.x).signum()).to_radians();
                let turn = if degrees == 0.0 || middle.x == centre.x { 0.0 } else { turn };
                let pose = if share == 0.0 && turn == 0.0 {
                    Pose::IDENTITY
                } else {
                    Pose::about(middle, burin::math::DQuat::from_rotation_z(turn), (middle - centre) * share)
                };
                bodies.push(Body { pose, region: planes, ..Body::whole(bodies.len() as u32) });
            }
        }
    }
    bodies
}
