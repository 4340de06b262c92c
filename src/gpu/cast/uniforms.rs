//! One picture as the shaders see it: the uniform structs, tables and lists of group 0.
//!
//! Owns the numbers that pass from `Frame` to `shaders/lib/body.wgsl`. World and index positions are taken relative to the
//! eye in f64 here, before the GPU's f32 sees them.

use crate::gpu::cast::holes::{Hole, Holes, kin_of, narrow};
use crate::gpu::cast::looks::{Looks, Meaning, number_of};
use crate::gpu::cast::merging::MergedBody;
use crate::gpu::cast::order::{Order, RayOrigin};
use crate::gpu::cast::tiles::{Tiles, Window};
use crate::gpu::device::constants::{FAR, MASK_BACKGROUND, MASK_SELECTION, MOST_BODIES, MOST_PLANES, NO_HOLE};
use crate::gpu::device::error::GpuError;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::{Frame, Mask, Overlay};
use crate::math::{DAffine3, DVec3, Projection};
use crate::shared_struct;

/// Loop iterations of one invocation are held below this; software Vulkan ends loops silently at 65,535.
const ITERATIONS: f64 = 60_000.0;

shared_struct! {
    /// See shaders/lib/body.wgsl.
    pub struct View {
        /// Ray through the picture's corner.
        pub corner: [f32; 3],
        /// Distance of samples.
        pub step_mm: f32,
        /// Change of the ray from pixel to pixel.
        pub dx: [f32; 3],
        /// 1, or 0 for orthographic.
        pub perspective: u32,
        /// Change of the ray from row to row.
        pub dy: [f32; 3],
        /// Texel of the iso-surface.
        pub iso: f32,
        /// Unit direction of sight.
        pub forward: [f32; 3],
        /// Entry of the table = texel·scale + bias.
        pub table_scale: f32,
        /// Ambient, diffuse, specular, power.
        pub lighting: [f32; 4],
        /// Display-referred.
        pub selection_colour: [f32; 3],
        /// See `table_scale`.
        pub table_bias: f32,
        /// 0..1.
        pub colour_opacity: f32,
        /// 0..1.
        pub label_opacity: f32,
        /// 0..1.
        pub selection_opacity: f32,
        /// First sample of this pass.
        pub k_from: f32,
        /// First sample of the next pass.
        pub k_to: f32,
        /// Pixels of the window.
        pub width: u32,
        /// Pixels of the window.
        pub height: u32,
        /// Unused.
        pub unused_a: u32,
        /// First cell of the map of what lies above `from_a`.
        pub above_a: [u32; 3],
        /// A texel; FAR where there is no such map.
        pub from_a: f32,
        /// The same above `from_b`.
        pub above_b: [u32; 3],
        /// A greater texel, or FAR.
        pub from_b: f32,
        /// The same above `from_c`.
        pub above_c: [u32; 3],
        /// A still greater texel, or FAR.
        pub from_c: f32,
        /// Of a ball that divides rays, as seen from the eye.
        pub ball_centre: [f32; 3],
        /// mm.
        pub ball_radius: f32,
        /// What of a ray is drawn.
        pub ball_keeps: u32,
        /// Unused.
        pub unused_b: u32,
        /// Unused.
        pub unused_c: u32,
        /// Unused.
        pub unused_d: u32,
    }
}

shared_struct! {
    /// See shaders/lib/body.wgsl.
    pub struct CastBody {
        /// index_from_world of the posed body, first column.
        pub column_x: [f32; 3],
        /// Its planes' place in the list.
        pub first_plane: u32,
        /// Second column.
        pub column_y: [f32; 3],
        /// Number of its planes.
        pub plane_count: u32,
        /// Third column.
        pub column_z: [f32; 3],
        /// 0 none, 1 selection, 2 background.
        pub mask: u32,
        /// The eye in index space.
        pub eye: [f32; 3],
        /// Object id in the picture, even; 1 more where its volume is selected.
        pub code: u32,
        /// Bounds in index space.
        pub lo: [f32; 3],
        /// The boxes of finer volumes in its family, as posed.
        pub first_hole: u32,
        /// Bounds in index space.
        pub hi: [f32; 3],
        /// How many.
        pub hole_count: u32,
        /// Multiplies colour.
        pub tint: [f32; 3],
        /// The one that it fills itself, or `NO_HOLE`.
        pub own_hole: u32,
    }
}

shared_struct! {
    /// See shaders/lib/body.wgsl.
    pub struct BodyMatter {
        /// The first cell of its map of empty space.
        pub skip_place: [u32; 3],
        /// Place among the volumes that are bound.
        pub volume: u32,
        /// Entry of the table = texel·scale + bias.
        pub table_scale: f32,
        /// See `table_scale`.
        pub table_bias: f32,
        /// Texel of the iso-surface.
        pub iso: f32,
        /// Of the table of looks.
        pub row: i32,
        /// Opacities of painted colour, labels, selection.
        pub overlay: [f32; 3],
        /// The first row of its volume's segment colours.
        pub segments_row: u32,
        /// See `MODE_DVR`.
        pub mode: u32,
        /// The first row of its looks by label.
        pub label_rows: u32,
        /// All labels beyond it have its look.
        pub last_label: u32,
        /// The least texel of the iso-surface of any label's look; `iso` where looks do not go by label.
        pub least_iso: f32,
        /// Display-referred.
        pub selection_colour: [f32; 3],
        /// The first of those that are one with it but for boxes of finer volumes.
        pub kin: u32,
    }
}

/// Everything that group 0 is filled with.
pub(crate) struct FrameUniforms {
    pub view: View,
    pub looks: Looks,
    pub bodies: Vec<CastBody>,
    pub matters: Vec<BodyMatter>,
    pub planes: Vec<[f32; 4]>,
    pub tiles: Tiles,
    /// Bounds `k_from`, `k_to` of each pass, nearest first; at least one.
    pub passes: Vec<[f32; 2]>,
    pub holes: Vec<Hole>,
    /// Into how many more pieces they may part the bodies that a ray meets.
    pub pieces: usize,
}

impl FrameUniforms {
    /// `skips`: the first cell of each body's map of empty space. The volumes must be bound.
    ///
    /// # Errors
    /// If there are more bodies or planes than fit, the step is no length, or `fields` has not the volume of a body.
    pub(crate) fn new(
        frame: &Frame,
        fields: &Fields<'_>,
        pools: &FieldPools,
        window: &Window,
        drawn: &[MergedBody],
        looks: Looks,
        skips: &[[u32; 3]],
    ) -> Result<Self, GpuError> {
        let plane_count = drawn.iter().map(|d| d.planes.len() + d.clips.len()).sum();
        if drawn.len() > MOST_BODIES as usize || plane_count > MOST_PLANES as usize {
            return Err(GpuError::TooManyBodies { bodies: drawn.len(), planes: plane_count });
        }
        if !(frame.step_mm.is_finite() && frame.step_mm > 0.0) {
            return Err(GpuError::BadStep { step_mm: frame.step_mm });
        }
        let camera = &frame.camera;
        let eye = camera.eye;
        let kin = kin_of(frame, drawn);
        let holes = Holes::new(frame, fields, pools, (drawn, &kin))?;
        let mut bodies = Vec::with_capacity(drawn.len());
        let mut planes = Vec::with_capacity(plane_count);
        let mut matters = Vec::with_capacity(drawn.len());
        for (i, (d, &skip_place)) in drawn.iter().zip(skips).enumerate() {
            let grid = fields.get(d.volume).ok_or(GpuError::NoVolume { id: d.volume.0 })?.grid;
            // Of labels that all have one kind of mode.
            let look = frame.look(d.labels.as_ref().map_or(d.look, |l| l.rows().first().copied()));
            let numbers = pools.value_of_texel(d.volume);
            let Meaning { table_scale, table_bias, iso } = Meaning::of(look, numbers);
            let of_labels = d.labels.iter().flat_map(|labels| labels.rows());
            let isos = of_labels.map(|row| Meaning::of(frame.look(Some(row)), numbers).iso);
            let (label_rows, last_label) = looks.labels_of(d);
            let overlay = frame.overlay_of(d.volume);
            matters.push(BodyMatter {
                skip_place,
                volume: pools.place_of(d.volume) as u32,
                table_scale,
                table_bias,
                iso,
                row: if d.labels.is_some() { -1 } else { looks.row_of(d.look) },
                overlay: d.overlay(frame),
                segments_row: looks.segments_of(d.volume),
                mode: number_of(look.mode),
                label_rows,
                last_label,
                least_iso: isos.fold(iso, f32::min),
                selection_colour: overlay.selection_colour,
                kin: kin[i] as u32,
            });
            let index_from_world: DAffine3 = grid.index_from_world() * d.pose.world_from_rest().inverse();
            let m = index_from_world.matrix3;
            let (of_body, own_hole) = (holes.of(frame, d), holes.filled_by(d));
            bodies.push(CastBody {
                column_x: narrow(m.x_axis),
                first_plane: planes.len() as u32,
                column_y: narrow(m.y_axis),
                plane_count: (d.planes.len() + d.clips.len()) as u32,
                column_z: narrow(m.z_axis),
                mask: match d.mask {
                    Mask::None => 0,
                    Mask::Selection => MASK_SELECTION,
                    Mask::Background => MASK_BACKGROUND,
                },
                eye: narrow(index_from_world.transform_point3(eye)),
                code: 2 * (i as u32 + 1),
                lo: narrow(d.bounds.min),
                first_hole: of_body.start,
                hi: narrow(d.bounds.max),
                hole_count: of_body.end - of_body.start,
                tint: d.tint.unwrap_or([1.0; 3]),
                own_hole: own_hole.unwrap_or(NO_HOLE),
            });
            for plane in d.planes.iter().map(|p| d.pose.apply_plane(p)).chain(d.clips.iter().copied()) {
                let [x, y, z] = narrow(plane.normal);
                planes.push([x, y, z, plane.distance(eye) as f32]);
            }
        }
        let solids: Vec<_> = drawn.iter().map(|d| d.solid.clone()).collect();
        let sight = RayOrigin::of(camera);
        let tiles = Tiles::of(&solids, &Order::of(&solids, sight), camera, window);
        let passes = passes(drawn, sight, eye, frame.step_mm, &tiles, (looks.refines, &holes));
        let view = view(frame, window, drawn.first(), pools);
        let pieces = holes.pieces();
        Ok(Self { view, looks, bodies, matters, planes, tiles, passes, holes: holes.ended(), pieces })
    }
}

/// The view, with the look of the first body, which is all bodies' if they have none of their own.
fn view(frame: &Frame, window: &Window, first: Option<&MergedBody>, pools: &FieldPools) -> View {
    let look = frame.look(first.and_then(|d| d.look));
    let meaning = Meaning::of(look, first.map_or((0.0, 1.0), |d| pools.value_of_texel(d.volume)));
    let overlay = first.map_or(&frame.overlay, |d| frame.overlay_of(d.volume));
    let camera = &frame.camera;
    let (right, up) = camera.right_up();
    let forward = camera.forward();
    let half = camera.half_height();
    let [w, h] = window.picture.map(f64::from);
    let pixel = 2.0 * half / h.max(1.0);
    let corner = forward + right * ((window.origin.x - 0.5 * w) * pixel) + up * ((0.5 * h - window.origin.y) * pixel);
    let Overlay { colour, labels, selection, selection_colour, .. } = *overlay;
    let light = look.lighting.unwrap_or_default();
    let ball = frame.layers.ball.as_ref();
    View {
        corner: narrow(corner),
        step_mm: frame.step_mm as f32,
        dx: narrow(right * pixel),
        perspective: u32::from(matches!(camera.projection, Projection::Perspective { .. })),
        dy: narrow(up * -pixel),
        iso: meaning.iso,
        forward: narrow(forward),
        table_scale: meaning.table_scale,
        lighting: [light.ambient, light.diffuse, light.specular, light.power],
        selection_colour,
        table_bias: meaning.table_bias,
        colour_opacity: colour,
        label_opacity: labels,
        selection_opacity: selection,
        k_from: 0.0,
        k_to: 0.0,
        width: window.size[0],
        height: window.size[1],
        unused_a: 0,
        above_a: [0; 3],
        from_a: FAR,
        above_b: [0; 3],
        from_b: FAR,
        above_c: [0; 3],
        from_c: FAR,
        ball_centre: ball.map_or([0.0; 3], |b| narrow(b.centre - camera.eye)),
        ball_radius: ball.map_or(0.0, |b| b.radius_mm as f32),
        ball_keeps: ball.map_or(0, |b| b.keeps.number()),
        unused_b: 0,
        unused_c: 0,
        unused_d: 0,
    }
}

/// Divides the lattice so that no invocation loops too often.
fn passes(
    drawn: &[MergedBody],
    sight: RayOrigin,
    eye: DVec3,
    step_mm: f64,
    tiles: &Tiles,
    (refine, holes): (bool, &Holes),
) -> Vec<[f32; 2]> {
    let corners = || drawn.iter().flat_map(|d| d.solid.corners());
    let far = |p: &DVec3| match sight {
        RayOrigin::Eye(_) => p.distance(eye),
        RayOrigin::Along(direction) => (*p - eye).dot(direction),
    };
    // Beyond that a sample's number is no whole number in 32-bit float, and a step of 1 leads nowhere.
    const LAST: f64 = 16_777_216.0;
    let last = ((corners().map(far).fold(0.0, f64::max) / step_mm).ceil() + 1.0).min(LAST);
    // Nothing lies nearer than the plane through the nearest corner that rays cross: square to all of them in orthographic
    // projection; from an eye any will do, best one across the mean direction.
    let along = match sight {
        RayOrigin::Eye(_) => (corners().sum::<DVec3>() / corners().count().max(1) as f64 - eye).normalize_or_zero(),
        RayOrigin::Along(direction) => direction,
    };
    let nearest = corners().map(|p| (*p - eye).dot(along)).fold(f64::INFINITY, f64::min);
    // A sample before it, since the GPU's narrower numbers may enter a body there.
    let first = ((nearest / step_mm).floor() - 1.0).max(0.0);
    // A sample costs at most four turns of loops per overlapping body, and five for the run it belongs to. One that refines is met
    // thrice and lit in twelve places. In a box light is asked of its host too.
    let (per_body, own) = match (refine, holes.list.is_empty()) {
        (true, _) => (24.0, 24.0),
        (false, true) => (4.0, 5.0),
        (false, false) => (6.0, 8.0),
    };
    let bodies = tiles.longest_merged as f64;
    // Where a ray meets boxes is asked once per body and box, several times for every piece.
    let to_find_pieces = 16.0 * (bodies + holes.list.len() as f64) * holes.largest_family() as f64;
    let left = (ITERATIONS - to_find_pieces).max(0.1 * ITERATIONS);
    let stride = (left / holes.finest / (per_body * bodies + own)).floor().max(1.0);
    let mut passes = Vec::new();
    let mut from = first;
    while from < last {
        passes.push([from as f32, (from + stride) as f32]);
        from += stride;
    }
    if passes.is_empty() {
        passes.push([0.0, 0.0]);
    }
    passes
}
