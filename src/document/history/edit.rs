//! What one command changes while it runs: the recording that becomes a step, or is taken back if the command fails.

use crate::document::command::resolved::{FileRead, ResolvedCommand};
use crate::document::disk::error::KeepError;
use crate::document::disk::source_files::{SourceFiles, Trouble, hash_one};
use crate::document::error::DocumentError;
use crate::document::history::step::{Bare, Refreshed, SceneDelta, Step, remap};
use crate::document::scene::Scene;
use crate::document::state::State;
use crate::io::FileMark;
use crate::volume::{
    BandBrick, Brick, BrickIndex, Changes, DensityMap, Field, FieldKey, FieldKind, SourceError, SubBox, Volume,
    VolumeId,
};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The recording of one command: what it changed as it was before, so that it can be taken back or made a step.
#[derive(Debug)]
pub(crate) struct Edit {
    scene: Option<Scene>,
    step: Step,
    files: Vec<FileRead>,
    refreshed: Refreshed,
    voxels: u64,
    bricks: usize,
    with_looks: bool,
}

impl Edit {
    /// Starts recording.
    pub(crate) fn new(state: Option<&State>) -> Self {
        Self {
            scene: state.map(|s| s.scene.clone()),
            step: Step { name: "Change".into(), ..Step::default() },
            files: Vec::new(),
            refreshed: Refreshed::default(),
            voxels: 0,
            bricks: 0,
            with_looks: false,
        }
    }

    /// What the step is called in the list of steps.
    pub(crate) fn name(&mut self, name: impl Into<String>) {
        self.step.name = name.into();
    }

    /// What the step was made by; files that were read come beside it.
    pub(crate) fn made_by(&mut self, command: ResolvedCommand) {
        let files = std::mem::take(&mut self.files);
        self.step.commands = vec![ResolvedCommand { files, ..command }];
    }

    /// Takes the hashes of files that the command read; `go_on` is asked meanwhile.
    ///
    /// # Errors
    /// If a file is not what it was when it was opened, or `go_on` said no.
    pub(crate) fn reads(&mut self, files: &[FileMark], proceed: &dyn Fn() -> bool) -> Result<(), DocumentError> {
        for mark in files {
            let hash = hash_one(mark, None, &|| !proceed()).map_err(Trouble::error)?.ok_or(DocumentError::Stopped)?;
            self.files.push(FileRead { path: mark.path.clone(), bytes: mark.bytes, blake3: hash });
        }
        Ok(())
    }

    /// Notes files that a volume was read from, once their hashes are known.
    ///
    /// # Errors
    /// As [`reads`](Self::reads).
    pub(crate) fn has_read(&mut self, files: &SourceFiles, proceed: &dyn Fn() -> bool) -> Result<(), DocumentError> {
        let hashes = files.hashes(proceed).map_err(|error| match error {
            KeepError::Stopped => DocumentError::Stopped,
            other => other.into(),
        })?;
        let read =
            |(mark, hash): (&FileMark, String)| FileRead { path: mark.path.clone(), bytes: mark.bytes, blake3: hash };
        self.files.extend(files.files().iter().zip(hashes).map(read));
        Ok(())
    }

    /// What the step is called so far.
    pub(crate) fn called(&self) -> &str {
        &self.step.name
    }

    /// The scene as it was.
    pub(crate) fn before(&self) -> Option<&Scene> {
        self.scene.as_ref()
    }

    /// Voxels that hold another value than before, and bricks with at least one.
    pub(crate) fn counts(&self) -> (u64, usize) {
        (self.voxels, self.bricks)
    }

    /// Exchanges bricks of a field and records them. A brick that equals the unedited one is no edit; one that equals the
    /// present one is left out.
    pub(crate) fn swap(&mut self, state: &mut State, key: FieldKey, changes: Changes) -> Result<(), SourceError> {
        self.swap_among(state, key, changes, &[])
    }

    /// The same where these volumes are changed too, each voxel as it is meant: their bands do not follow.
    pub(crate) fn swap_among(
        &mut self,
        state: &mut State,
        key: FieldKey,
        changes: Changes,
        among: &[VolumeId],
    ) -> Result<(), SourceError> {
        let indices: Vec<BrickIndex> = changes.iter().map(|(index, _)| *index).collect();
        let mut bands = bands_of(state, key, &indices)?;
        bands.retain(|(id, ..)| !among.contains(id));
        self.swap_alone(state, key, changes)?;
        for (id, of, bricks) in bands {
            if key.kind == FieldKind::Density {
                self.make_room(state, (key.volume, id), &bricks)?;
            }
            let (Some(parent), Some(fine)) = (state.field(key), state.volumes.get(&id)) else { continue };
            let own = fine.field(key.kind);
            let followed = bricks.par_iter().map(|brick| brick.followed(&of, own, parent));
            let followed = followed.collect::<Result<Vec<_>, SourceError>>()?.into_iter().flatten();
            let followed: Changes = followed.map(|(index, brick)| (index, Some(brick))).collect();
            // What only follows is nobody's to count.
            let counts = (self.voxels, self.bricks);
            self.swap(state, FieldKey::new(id, key.kind), followed)?;
            (self.voxels, self.bricks) = counts;
        }
        Ok(())
    }

    /// Lets a sub-volume hold what its band follows, where its codes end before.
    fn make_room(
        &mut self,
        state: &mut State,
        (parent, id): (VolumeId, VolumeId),
        bricks: &[BandBrick],
    ) -> Result<(), SourceError> {
        let (Some(coarse), Some(fine)) = (state.volumes.get(&parent), state.volumes.get(&id)) else { return Ok(()) };
        let map = *fine.density.map();
        for brick in bricks {
            if brick.is_beyond(&map, &coarse.density)? {
                return self.remap(state, id, map.in_floats());
            }
        }
        Ok(())
    }

    fn swap_alone(&mut self, state: &mut State, key: FieldKey, changes: Changes) -> Result<(), SourceError> {
        let Some(volume) = state.volumes.get_mut(&key.volume) else { return Ok(()) };
        let field = volume.field_mut(key.kind);
        let judged = changes
            .into_par_iter()
            .map(|(index, brick)| judge(field, index, brick))
            .collect::<Result<Vec<_>, SourceError>>()?;
        let mut real = Vec::new();
        for (index, brick, differing) in judged.into_iter().flatten() {
            self.voxels += differing;
            self.bricks += usize::from(differing > 0);
            real.push((index, brick));
        }
        if real.is_empty() {
            return Ok(());
        }
        let (before, refresh) = field.swap(real)?;
        self.refreshed.slots.push((key, refresh));
        let before = before.into_iter().map(|(index, brick)| ((key, index), brick)).collect();
        self.step.absorb(Step { name: self.step.name.clone(), bricks: before, ..Step::default() });
        Ok(())
    }

    /// Gives the density a map that holds more values; edits keep theirs.
    pub(crate) fn remap(&mut self, state: &mut State, id: VolumeId, map: DensityMap) -> Result<(), SourceError> {
        let Some(volume) = state.volumes.get_mut(&id) else { return Ok(()) };
        let density = &volume.density;
        let edits = density
            .edits()
            .into_par_iter()
            .map(|(index, brick)| Ok((index, Some(recode(density, &map, index, brick)?))))
            .collect::<Result<Vec<_>, SourceError>>()?;
        let (old, before) = remap(&mut volume.density, map, edits)?;
        self.refreshed.remapped.insert(id);
        let key = FieldKey::new(id, FieldKind::Density);
        let bricks = before.into_iter().map(|(index, brick)| ((key, index), brick)).collect();
        let maps = BTreeMap::from([(id, old)]);
        self.step.absorb(Step { name: self.step.name.clone(), bricks, maps, ..Step::default() });
        Ok(())
    }

    /// Takes back what was done so far to the voxels, the map and the segments of one volume; what others got stays.
    ///
    /// # Errors
    /// If the source fails; the volume is then as it is.
    pub(crate) fn spare(&mut self, state: &mut State, id: VolumeId) -> Result<(), SourceError> {
        let bricks = std::mem::take(&mut self.step.bricks);
        let (bricks, others) = bricks.into_iter().partition(|((key, _), _)| key.volume == id);
        self.step.bricks = others;
        let maps = self.step.maps.remove_entry(&id).into_iter().collect();
        let mut own = Step { name: self.step.name.clone(), bricks, maps, ..Step::default() };
        if !own.is_empty() {
            match own.exchange(state) {
                Ok(refreshed) => self.refreshed.join(refreshed),
                Err(error) => {
                    self.step.absorb(own);
                    return Err(error);
                }
            }
        }
        let before = self.scene.as_ref().and_then(|scene| scene.volumes.all.get(&id)).map(|v| &v.segments);
        let now = state.scene.volumes.all.get(&id).map(|v| &v.segments);
        if let (Some(before), true) = (before, before != now)
            && let Some(segments) = state.scene.segments_mut(id)
        {
            segments.clone_from(before);
        }
        Ok(())
    }

    /// How volumes are shown changes with this step, and is taken back with it.
    pub(crate) fn takes_looks(&mut self) {
        self.with_looks = true;
    }

    /// Puts a volume beside the others, with what is painted on it.
    pub(crate) fn add(&mut self, state: &mut State, id: VolumeId, bare: Bare) {
        let edits = FieldKind::ALL.into_iter().flat_map(|kind| {
            let key = FieldKey::new(id, kind);
            bare.volume.field(kind).edits().into_keys().map(move |index| ((key, index), None))
        });
        let bricks = edits.collect();
        let volumes = BTreeMap::from([(id, None)]);
        self.refreshed.exchanged.insert(id);
        state.volumes.insert(id, bare.volume);
        if let Some(files) = bare.files {
            state.files.insert(id, files);
        }
        self.step.absorb(Step { name: self.step.name.clone(), bricks, volumes, ..Step::default() });
    }

    /// Puts a volume in the place of one, with what is painted on both.
    pub(crate) fn replace(&mut self, state: &mut State, id: VolumeId, volume: Volume) {
        self.refreshed.exchanged.insert(id);
        let Some(before) = state.volumes.insert(id, volume) else { return };
        let (bare, bricks) = Bare { volume: before, files: None }.apart(id);
        let volumes = BTreeMap::from([(id, Some(bare))]);
        self.step.absorb(Step { name: self.step.name.clone(), bricks, volumes, ..Step::default() });
    }

    /// Takes a volume away, with what is painted on it.
    pub(crate) fn remove(&mut self, state: &mut State, id: VolumeId) -> Result<(), SourceError> {
        let volumes = BTreeMap::from([(id, None)]);
        let mut step = Step { name: self.step.name.clone(), volumes, ..Step::default() };
        let refreshed = step.exchange(state)?;
        self.refreshed.join(refreshed);
        self.step.absorb(step);
        Ok(())
    }

    /// The step, unless nothing changed, and what is new for whoever mirrors fields.
    pub(crate) fn finish(mut self, state: &State) -> (Option<Step>, Refreshed) {
        if let Some(before) = self.scene.take() {
            self.step.scene = SceneDelta::between(&before, &state.scene, self.with_looks);
        }
        self.refreshed.bricks = self.step.bricks.keys().copied().collect();
        let step = (!self.step.is_empty()).then_some(self.step);
        (step, self.refreshed)
    }

    /// Takes everything back.
    pub(crate) fn roll_back(mut self, state: &mut State) -> Result<Refreshed, SourceError> {
        if let Some(before) = self.scene.take() {
            before.looks().exchange(&mut state.scene);
            SceneDelta::between(&before, &state.scene, true).exchange(&mut state.scene);
        }
        let mut refreshed = self.step.exchange(state)?;
        refreshed.join(self.refreshed);
        Ok(refreshed)
    }
}

/// The bricks of sub-volumes' bands that follow bricks of a field which are about to change.
fn bands_of(
    state: &State,
    key: FieldKey,
    indices: &[BrickIndex],
) -> Result<Vec<(VolumeId, SubBox, Vec<BandBrick>)>, SourceError> {
    let Some(parent) = state.field(key) else { return Ok(Vec::new()) };
    let bands =
        state.scene.boxes_of(key.volume).map(|(id, sub)| Ok((id, sub.of, BandBrick::of(&sub.of, parent, indices)?)));
    let bands = bands.collect::<Result<Vec<_>, SourceError>>()?;
    Ok(bands.into_iter().filter(|(_, _, bricks)| !bricks.is_empty()).collect())
}

type Judged = Option<(BrickIndex, Option<Brick>, u64)>;

/// The change in its plainest form and the number of voxels that differ; `None` if it changes nothing.
fn judge(field: &Field, index: BrickIndex, brick: Option<Brick>) -> Result<Judged, SourceError> {
    if field.edit(index) == brick.as_ref() {
        return Ok(None);
    }
    let (bytes, valid) = (field.format().bytes(), field.valid(0, index));
    let base = field.base_brick(index)?;
    let edited = field.edit(index);
    let new = brick.as_ref().unwrap_or(&base);
    let unlike_base = new.differing(&base, valid, bytes);
    let differing = edited.map_or(unlike_base, |old| new.differing(old, valid, bytes));
    let brick = if unlike_base == 0 { None } else { brick };
    Ok((edited != brick.as_ref()).then_some((index, brick, differing)))
}

/// An edited brick in the codes of another map: unedited texels are the source's own, the others keep their value.
fn recode(density: &Field, map: &DensityMap, index: BrickIndex, brick: &Brick) -> Result<Brick, SourceError> {
    let (old_map, bytes, new_bytes) = (*density.map(), density.format().bytes(), map.format.bytes());
    let Some(source) = density.source() else { return Ok(brick.clone()) };
    let valid = density.valid(0, index);
    let base = density.base_brick(index)?;
    let mut fresh = Vec::new();
    map.encode_voxels(&source.read(index.origin(), valid)?, source.scaling(), &mut fresh);
    let mut texels = vec![0; crate::volume::BRICK_VOXELS * new_bytes];
    let mut i = 0;
    for z in 0..valid[2] {
        for y in 0..valid[1] {
            for x in 0..valid[0] {
                let at = [x, y, z];
                let (now, was) = (brick.texel(at, bytes), base.texel(at, bytes));
                let encoded = map.encode(old_map.decode(now));
                let new = if now == was { &fresh[i..i + new_bytes] } else { &encoded[..new_bytes] };
                let edge = crate::volume::BRICK;
                let to = (x + edge * (y + edge * z)) as usize * new_bytes;
                texels[to..to + new_bytes].copy_from_slice(new);
                i += new_bytes;
            }
        }
    }
    Ok(Brick::from_texels(texels, new_bytes))
}
