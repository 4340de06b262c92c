//! Questions; they change nothing.

use crate::document::Document;
use crate::document::apply::sub_volume;
use crate::document::command::Question;
use crate::document::command::answers::{Said, SceneSaid};
use crate::document::command::answers_ask::{
    FieldSaid, HiddenBy, HistorySaid, HitSaid, PartsSaid, PastCounts, PickSaid, VisibilitySaid, VolumeSaid,
    VolumeVoxelSaid, VoxelSaid, VoxelValues,
};
use crate::document::error::DocumentError;
use crate::document::family::{Family, Member};
use crate::document::frame::WHOLE;
use crate::document::live::contact::ContactForce;
use crate::document::scene::check::check_size;
use crate::document::scene::check::safe_camera;
use crate::document::scene::past::PastOf;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::explode::{Part, PartRecord};
use crate::math::{DVec2, DVec3};
use crate::volume::{Asked, BrickIndex, Field, FieldKind, Number, SourceError, Statistics, SubBox, Total};
use rayon::prelude::*;
use std::collections::BTreeMap;

impl Document {
    pub(crate) fn ask(&mut self, question: &Question) -> Result<Said, DocumentError> {
        Ok(match *question {
            Question::Volume { volume: id } => {
                let subject = self.open()?.at(id)?;
                match subject.measured()? {
                    Some(own) => volume_with(&subject, &own.statistics).into(),
                    None => volume(&subject).into(),
                }
            }
            Question::SubVolumes { volume: id } => sub_volume::list(self.open()?, id)?.into(),
            Question::SubVolumeFit { volume: id, lo, hi, scale } => {
                sub_volume::fit(self.open()?, id, SubBox { lo, hi, scale: scale.each() })?.into()
            }
            Question::Scene {} => SceneSaid { scene: self.open()?.scene.clone(), parts: self.standing_parts()? }.into(),
            Question::Parts {} => {
                PartsSaid { degree: self.open()?.scene.explosion.degree, parts: self.standing_parts()? }.into()
            }
            Question::Voxel { at, volume: id } => {
                let world = self.resolve(at, id)?.map(|sample| sample.position);
                match world {
                    Some(world) => {
                        let state = self.open()?;
                        VoxelSaid { volumes: all_at(state, world)?, ..voxel(&state.at(id)?, world)? }.into()
                    }
                    None => VoxelSaid::default().into(),
                }
            }
            Question::Field { field, volume: id } => {
                let state = self.open()?;
                sums(state, &state.family(state.at(id)?.id)?, field)?.into()
            }
            Question::History { commands } => {
                let (memory, disk) = self.history.bytes();
                let past = |of| {
                    let (back, forward) = self.state.as_ref().map_or((0, 0), |s| s.past.counts(Some(of)));
                    PastCounts { back, forward }
                };
                HistorySaid {
                    undo: self.history.undo_names().rev().map(str::to_owned).collect(),
                    redo: self.history.redo_names().map(str::to_owned).collect(),
                    memory,
                    disk,
                    budget: self.history.budget_bytes(),
                    views: past(PastOf::Views),
                    looks: past(PastOf::Looks),
                    undo_commands: if commands { Some(self.history.undo_commands()?) } else { None },
                    redo_commands: if commands { Some(self.history.redo_commands()?) } else { None },
                }
                .into()
            }
            Question::Annotations { id, vertices } => self.ask_annotations(id, vertices)?.into(),
            Question::Labels { camera, size } => self.ask_labels(camera, size)?.into(),
            Question::Cutaways { id, mesh } => self.ask_cutaways(id, mesh)?.into(),
            Question::Pick { px, size } => {
                let Some(hit) = self.pick(DVec2::from_array(px), size)? else {
                    return Ok(PickSaid { hit: None }.into());
                };
                let state = self.open()?;
                let subject = state.at(hit.object.volume())?;
                let index = subject.grid().index_from_world().transform_point3(hit.rest);
                let hit = HitSaid {
                    mm: hit.world.to_array(),
                    rest_mm: hit.rest.to_array(),
                    index: index.to_array(),
                    part: state.part_at(hit.body, hit.rest)?,
                    volume: hit.object.volume(),
                    segment: hit.object.segment(),
                    selection: hit.body == WHOLE && !subject.selection.is_blank(),
                    selected: hit.object.is_selected(),
                    depth_mm: hit.depth_mm,
                };
                PickSaid { hit: Some(hit) }.into()
            }
            Question::Contact { at, volume, value, stiffness, most, tolerance_mm } => {
                let usual = ContactForce::default();
                let law = ContactForce {
                    stiffness_n_per_mm: stiffness.unwrap_or(usual.stiffness_n_per_mm),
                    most_n: most.unwrap_or(usual.most_n),
                    tolerance_mm: tolerance_mm.unwrap_or(usual.tolerance_mm),
                };
                self.ask_contact(at, volume, value, &law)?.into()
            }
            Question::Visibility { camera, size } => {
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let views = &state.scene.views;
                let camera = safe_camera(camera.unwrap_or(views.camera), &state.bounds())?;
                let size = check_size(size.unwrap_or(views.size))?;
                let mut frame = state.parted_frame(self.motion.poses(), &camera, size);
                self.lay_out(&mut frame.layers, false, true);
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let seen = self.graphics.visibility(state, &frame)?;
                let hidden = seen.hidden_by.iter().map(|&(part, pixels)| HiddenBy { part, pixels });
                VisibilitySaid {
                    share: seen.share(),
                    selected: seen.selected,
                    visible: seen.visible,
                    hidden_by: hidden.collect(),
                }
                .into()
            }
        })
    }

    /// The parts and where they stand.
    fn standing_parts(&self) -> Result<Vec<PartRecord>, DocumentError> {
        let poses = self.motion.poses();
        let standing = |part: &Part| PartRecord::of(part, poses.of(part));
        Ok(self.open()?.scene.explosion.parts.iter().map(standing).collect())
    }
}

/// What is said of a volume, with what was measured when it was opened; of a sub-volume that of what it is cut out of.
pub(crate) fn volume(subject: &Subject<'_>) -> VolumeSaid {
    volume_with(subject, &subject.statistics)
}

fn volume_with(subject: &Subject<'_>, statistics: &Statistics) -> VolumeSaid {
    let grid = subject.grid();
    let m = grid.world_from_index;
    let rows: [[f64; 4]; 3] = std::array::from_fn(|r| {
        let row = m.matrix3.row(r);
        [row.x, row.y, row.z, m.translation[r]]
    });
    let [min, max, sum] = statistics.numbers();
    // Of a volume without a finite value there is neither.
    let [min, max] = [min, max].map(|n| (!n.is_nan()).then_some(n));
    VolumeSaid {
        name: subject.source.name().to_owned(),
        dims: grid.dims,
        voxel_type: subject.source.voxel_type(),
        world_from_index: rows,
        spacing_mm: grid.spacing().to_array(),
        min,
        max,
        sum,
        nan_count: statistics.nan_count,
        texels: subject.density.format(),
        half_step: subject.half_step(),
        levels: subject.density.level_count(),
    }
}

/// What every visible volume has at a place of the world; nothing where there is only one volume.
fn all_at(state: &State, world: DVec3) -> Result<Vec<VolumeVoxelSaid>, DocumentError> {
    if state.volumes.len() < 2 {
        return Ok(Vec::new());
    }
    let visible = state.subjects().filter(|subject| subject.settings.visible);
    let one = |subject: Subject<'_>| {
        let values = voxel(&subject, world)?.values;
        Ok(VolumeVoxelSaid { volume: subject.id, name: subject.settings.name.clone(), values })
    };
    visible.map(one).collect()
}

fn voxel(subject: &Subject<'_>, world: DVec3) -> Result<VoxelSaid, DocumentError> {
    let index = subject.grid().index_from_world().transform_point3(world);
    let place = VoxelSaid { mm: Some(world.to_array()), index: Some(index.to_array()), ..VoxelSaid::default() };
    let Some(voxel) = subject.grid().voxel_at(index) else { return Ok(place) };
    let texel = subject.colour.texel(voxel)?;
    let label = subject.labels.value(voxel)? as u16;
    let values = subject.density.values(voxel, [1; 3])?;
    let painted = values.painted.first().map(|&(_, value)| value);
    let own = values.unpainted(0);
    let values = VoxelValues {
        voxel,
        density: painted.map_or(own, Number::Real),
        half_step: painted.map_or(0.0, |value| subject.half_step_at(value, own.to_f64())),
        colour: texel.map(|c| f32::from(c) / 255.0),
        selection: subject.selection.value(voxel)?,
        label,
        segment: subject.segments().get(label).map(|s| s.name.clone()),
    };
    Ok(VoxelSaid { inside: true, values: Some(values), ..place })
}

#[derive(Default)]
struct Sums {
    /// Of integers, which lose nothing, and of all other numbers.
    whole: i128,
    real: Total,
    nonzero: u64,
    ends: Option<[Number; 2]>,
    /// Whether any number was not an integer.
    fractions: bool,
    labels: BTreeMap<u16, u64>,
    /// Of what is selected, mm³, and of each label.
    selected_mm3: Total,
    labels_mm3: BTreeMap<u16, f64>,
}

impl Sums {
    fn add(&mut self, number: Number) {
        match number {
            Number::Real(x) if !x.is_finite() => return,
            Number::Real(x) => {
                self.real.add(x);
                self.fractions = true;
            }
            Number::Whole(n) => self.whole += n,
        }
        self.nonzero += u64::from(number != Number::Whole(0));
        self.widen([number; 2]);
    }

    fn widen(&mut self, [least, greatest]: [Number; 2]) {
        let [min, max] = self.ends.unwrap_or([least, greatest]);
        self.ends = Some([if least < min { least } else { min }, if greatest > max { greatest } else { max }]);
    }

    fn join(mut self, other: Self) -> Self {
        self.whole += other.whole;
        self.real.merge(&other.real);
        self.nonzero += other.nonzero;
        self.fractions |= other.fractions;
        other.ends.into_iter().for_each(|ends| self.widen(ends));
        self.selected_mm3.merge(&other.selected_mm3);
        for (label, count) in other.labels {
            *self.labels.entry(label).or_default() += count;
        }
        for (label, mm3) in other.labels_mm3 {
            *self.labels_mm3.entry(label).or_default() += mm3;
        }
        self
    }

    fn sum(&self) -> Number {
        if self.fractions { Number::Real(self.whole as f64 + self.real.value()) } else { Number::Whole(self.whole) }
    }
}

/// Sum, count of non-zero, smallest and largest of the finite values of a volume, of sub-volumes in place of the voxels that they stand
/// for; colour counts by its alpha. Brick by brick in order, so that the answer is the same on every run.
fn sums(state: &State, family: &Family, kind: FieldKind) -> Result<FieldSaid, SourceError> {
    let mut all = Sums::default();
    let mut edited_bricks = 0;
    for (member, subject) in family.subjects(state) {
        let field = subject.field(kind);
        let of_brick = |index: BrickIndex| of_brick(field, member, index);
        let bricks = field.brick_indices(0).into_par_iter().map(of_brick).collect::<Result<Vec<_>, _>>()?;
        all = bricks.into_iter().fold(all, Sums::join);
        edited_bricks += field.edits().len();
    }
    Ok(FieldSaid {
        field: kind.name(),
        sum: all.sum(),
        nonzero: all.nonzero,
        min: all.ends.map(|[min, _]| min),
        max: all.ends.map(|[_, max]| max),
        edited_bricks,
        voxels_by_label: (kind == FieldKind::Labels).then_some(all.labels),
        mm3_by_label: (kind == FieldKind::Labels).then_some(all.labels_mm3),
        selected_mm3: (kind == FieldKind::Selection).then(|| all.selected_mm3.value()),
    })
}

fn of_brick(field: &Field, member: &Member, index: BrickIndex) -> Result<Sums, SourceError> {
    let (kind, origin, valid) = (field.kind(), index.origin(), field.valid(0, index));
    let standing = &member.standing;
    let (asked, is_odd) = (standing.brick(index), standing.is_odd_in(index));
    let mut sums = Sums::default();
    if asked == Asked::None {
        return Ok(sums);
    }
    let voxel = |i: usize| {
        let i = i as u32;
        [origin[0] + i % valid[0], origin[1] + i / valid[0] % valid[1], origin[2] + i / (valid[0] * valid[1])]
    };
    let is_asked = |i: usize| asked == Asked::All || standing.is_asked(voxel(i));
    if kind == FieldKind::Density {
        field.values(origin, valid)?.each(|i, number| {
            if is_asked(i) {
                sums.add(number);
            }
        });
        return Ok(sums);
    }
    let bytes = field.format().bytes();
    let texels = field.read(0, origin.map(i64::from), valid)?;
    for (i, texel) in texels.chunks_exact(bytes).enumerate().filter(|(i, _)| is_asked(*i)) {
        let mm3 = || member.voxel_mm3 * if is_odd { standing.share(voxel(i)) } else { 1.0 };
        match kind {
            FieldKind::Labels => {
                let label = u16::from_le_bytes([texel[0], texel[1]]);
                sums.add(Number::Whole(label.into()));
                if label != 0 {
                    *sums.labels.entry(label).or_default() += 1;
                    *sums.labels_mm3.entry(label).or_default() += mm3();
                }
            }
            // A colour's alpha, or the selection itself.
            _ => {
                let value = f64::from(texel[bytes - 1]) / 255.0;
                sums.add(Number::Real(value));
                if kind == FieldKind::Selection && value > 0.0 {
                    sums.selected_mm3.add(value * mm3());
                }
            }
        }
    }
    Ok(sums)
}
