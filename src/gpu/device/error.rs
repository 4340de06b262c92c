//! What can go wrong on the GPU floor, in words that a user can act on.
//!
//! Owns [`GpuError`] and nothing else. Out of memory and a lost device are answers here, never crashes.

use crate::paint::PaintError;
use crate::volume::SourceError;

/// Errors of the GPU floor.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// There is nothing to draw with.
    #[error(
        "no graphics adapter found ({reason}); a Vulkan, Metal or Direct3D 12 driver is expected. On Debian and Ubuntu \
         software Vulkan comes with: apt install mesa-vulkan-drivers libvulkan1"
    )]
    NoAdapter {
        /// What the system said.
        reason: String,
    },
    /// The adapter gave no device.
    #[error("the graphics adapter {adapter} gave no device: {reason}; update its driver or choose another adapter")]
    NoDevice {
        /// Adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The GPU has no room.
    #[error("out of graphics memory for {what}: {reason}; lower the memory budget or close other programs")]
    OutOfMemory {
        /// What was to be made.
        what: String,
        /// Sizes or the driver's words.
        reason: String,
    },
    /// The device refused a call: a defect of this program or of the driver.
    #[error("the graphics device refused {what}: {reason}; please report this with the adapter's name")]
    Refused {
        /// What was to be done.
        what: String,
        /// The device's words.
        reason: String,
    },
    /// The device is gone; everything on it can be made again from the host's fields.
    #[error(
        "the graphics device was lost ({reason}); nothing is lost but the picture, which is made again on a new device"
    )]
    Lost {
        /// The driver's words.
        reason: String,
    },
    /// A shader does not compose or does not validate.
    #[error("shader {file}: {reason}")]
    Shader {
        /// File under `shaders/`.
        file: String,
        /// What the compiler said.
        reason: String,
    },
    /// A request that the pools cannot hold.
    #[error(
        "{asked} bricks of {field} asked for at once, the pool holds {room}; raise the memory budget or use a smaller brush"
    )]
    PoolFull {
        /// Field.
        field: &'static str,
        /// Bricks asked for.
        asked: usize,
        /// Bricks that fit.
        room: usize,
    },
    /// A picture or a stroke names a volume that does not exist.
    #[error("volume {id} is asked for, which is not among those that are open")]
    NoVolume {
        /// Its name.
        id: u32,
    },
    /// More looks than one picture can have.
    #[error("{looks} looks in one picture, {most} fit; let some segments or parts inherit theirs")]
    TooManyLooks {
        /// Looks.
        looks: usize,
        /// Those that fit.
        most: usize,
    },
    /// More boxes of finer volumes than one picture can show.
    #[error("{boxes} sub-volumes in one picture, each counted for every part that it lies in, {most} fit; hide some")]
    TooManyBoxes {
        /// Boxes.
        boxes: usize,
        /// Those that fit.
        most: usize,
    },
    /// More volumes than one picture can show.
    #[error("{volumes} volumes in one picture, {most} fit; hide some")]
    TooManyVolumes {
        /// Volumes.
        volumes: usize,
        /// Those that fit.
        most: usize,
    },
    /// A stroke that needs more memory than it may take.
    #[error(
        "the stroke needs {needed} bytes of graphics memory, {budget} are allowed; end it here, use a smaller brush or raise \
         the stroke's budget"
    )]
    StrokeTooLarge {
        /// Bytes with the next bricks.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// Density cannot hold what the brush makes. Widen its map to `needed`, then begin the stroke again.
    #[error(
        "the brush makes densities from {} to {}, the volume's 16-bit texels hold {} to {}; widen their range first",
        needed[0], needed[1], held[0], held[1]
    )]
    BeyondRange {
        /// Values to make room for, what is held included.
        needed: [f64; 2],
        /// Values of the first and the last code.
        held: [f64; 2],
    },
    /// A call that does not fit the stroke's state.
    #[error("stroke: {0}")]
    Stroke(&'static str),
    /// A brush or sample that is not valid.
    #[error(transparent)]
    Paint(#[from] PaintError),
    /// A picture of more bodies than the caster takes.
    #[error(
        "a picture of {bodies} bodies with {planes} cutting planes asked for, at most 512 and 4096 fit; hide some parts"
    )]
    TooManyBodies {
        /// Bodies.
        bodies: usize,
        /// Planes of all of them.
        planes: usize,
    },
    /// More meshes than a picture takes.
    #[error(
        "a picture of {meshes} meshes of one kind with {triangles} triangles asked for, at most 64 and 268,435,456 fit; hide some or \
         join them"
    )]
    TooManyMeshes {
        /// Meshes.
        meshes: usize,
        /// Triangles of all of them.
        triangles: usize,
    },
    /// More faces one behind another than a ray can be cut by.
    #[error(
        "cutting meshes with more than {most} faces one behind another in a pixel found; simplify them or hide some"
    )]
    TooManyFaces {
        /// As many fit.
        most: u32,
    },
    /// A grid over more of a surface than the pools hold.
    #[error(
        "the grid's surroundings are {asked} bricks of {field}, {room} fit at full resolution; raise the memory budget, or ask for fewer \
         or shorter steps"
    )]
    GridTooLarge {
        /// Field.
        field: &'static str,
        /// Bricks asked for.
        asked: usize,
        /// Bricks that fit.
        room: usize,
    },
    /// A grid of more steps than one particle can go.
    #[error("{steps} steps of the grid from its centre asked for, at most {most} fit through {volumes} volumes")]
    TooManySteps {
        /// Along an axis of the grid.
        steps: u32,
        /// Those that fit.
        most: u32,
        /// Volumes that tell the surface.
        volumes: usize,
    },
    /// A grid's number that is none.
    #[error("{what}: {found} found, {expected} expected")]
    BadGrid {
        /// Of the request.
        what: &'static str,
        /// As given.
        found: String,
        /// What is possible.
        expected: &'static str,
    },
    /// A step that is no length.
    #[error("step_mm: {step_mm} found, a positive length expected")]
    BadStep {
        /// As given.
        step_mm: f64,
    },
    /// The volume could not be read.
    #[error(transparent)]
    Source(#[from] SourceError),
}
