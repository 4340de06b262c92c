//! From a volume file to a document, in three passes over the voxels: statistics, histogram, levels.

use crate::document::Document;
use crate::document::apply::trail::Resolved;
use crate::document::command::Command;
use crate::document::command::answers::{Answer, LabelsSaid, OpenedSaid, RecoveredSaid, Said, StrokeFate};
use crate::document::command::files::{OpenAs, USUAL_COMPONENT, VolumeCommand};
use crate::document::disk::error::KeepError;
use crate::document::error::DocumentError;
use crate::document::journal::autosave::Autosave;
use crate::document::journal::loaded::{Recovered, RestoredDocument};
use crate::document::project::read::Wanted;
use crate::document::scene::histogram::histogram;
use crate::document::scene::kept_poses::SavedPoses;
use crate::document::scene::{Origin, Scene};
use crate::document::state::State;
use crate::explode::{Explosion, Poses};
use crate::io;
use crate::volume::{FieldKey, FieldKind, VolumeId};
use std::path::Path;

impl State {
    /// Opens a volume file as a new document's state. `progress` gets the share done and answers whether to go on; it is asked
    /// from several threads.
    ///
    /// # Errors
    /// Whatever keeps the file from being read, a range that is none, or [`DocumentError::Stopped`].
    pub fn open(
        origin: Origin,
        range: Option<[f64; 2]>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Self, DocumentError> {
        let path = std::path::absolute(&origin.path).unwrap_or_else(|_| origin.path.clone());
        let opened = io::open(&path)?;
        let source = opened.source(origin.component, origin.frame, &|x| progress(x * 0.2))?;
        let statistics = io::statistics(source.as_ref(), &|x| progress(0.2 + x * 0.2))?;
        let histogram = histogram(source.as_ref(), &statistics, &|x| progress(0.4 + x * 0.2))?;
        let files = opened.files;
        let marks = files.clone();
        let origin = Origin { path, ..origin };
        let volume = crate::document::state::over(source, statistics, histogram, range, &|x| progress(0.6 + x * 0.4))?;
        still_as_opened(&marks)?;
        Ok(Self::of_one(volume, origin, files))
    }
}

/// Fails if a file was written to while it was read: part of what was read would be of another volume.
fn still_as_opened(files: &[io::FileMark]) -> Result<(), DocumentError> {
    for file in files {
        let now = io::FileMark::of(&file.path).ok();
        let same = |now: &io::FileMark| (now.bytes, now.modified_ns) == (file.bytes, file.modified_ns);
        if !now.as_ref().is_some_and(same) {
            let found = format!("{}, which was written to while it was read", file.path.display());
            return Err(DocumentError::invalid("path", found, "a file that stays as it is; open it again"));
        }
    }
    Ok(())
}

/// A document that was read and waits to be taken: reading needs no [`Document`] and may be done on another thread.
#[derive(Debug)]
pub struct ReadDocument {
    state: State,
    /// Where forces had taken the parts.
    poses: SavedPoses,
    autosave: Option<Autosave>,
    recovered: Recovered,
    warnings: Vec<String>,
    /// Of a file that was opened as labels, or as a selection.
    labels: Option<LabelsSaid>,
    selected_voxels: Option<u64>,
}

impl ReadDocument {
    /// A volume file as a new, unsaved document; noted for recovery below `unsaved_in`, if given. See [`State::open`].
    ///
    /// # Errors
    /// As [`State::open`]; as labels or selection also what keeps the values from being such.
    pub fn volume(
        origin: Origin,
        range: Option<[f64; 2]>,
        open_as: OpenAs,
        unsaved_in: Option<&Path>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Self, DocumentError> {
        let file = io::open(&origin.path)?;
        let usual = if open_as == OpenAs::Image { file.usual_component() } else { 0 };
        let component = if origin.component == USUAL_COMPONENT { usual } else { origin.component };
        let origin = Origin { component, ..origin };
        let Origin { path, component, frame } = origin.clone();
        let mut warnings = file.warnings.clone();
        let coloured = file.colour && component == file.components;
        let share = if open_as == OpenAs::Image && !coloured { 1.0 } else { 0.6 };
        let mut state = State::open(origin, range, &|x| progress(x * share))?;
        let subject = state.at(None)?;
        let proceed: &(dyn Fn(f32) -> bool + Sync) = &|x| progress(0.6 + x * 0.4);
        let (mut labels, mut selected_voxels) = (None, None);
        let filled = match open_as {
            OpenAs::Image => {
                let parts = if coloured { file.colours(frame, &|x| progress(0.6 + x * 0.1))? } else { None };
                let filled = parts.map(|parts| {
                    crate::document::apply::colours::changes(&subject.volume.colour, &parts, &|x| {
                        progress(0.7 + x * 0.3)
                    })
                });
                filled.transpose()?.map(|changes| (FieldKind::Colour, changes))
            }
            OpenAs::Labels => {
                let imported = crate::document::apply::labels::import(
                    &subject,
                    &*subject.volume.source,
                    &file.labels_of(component),
                    proceed,
                )?;
                let id = subject.id;
                if let Some(segments) = state.scene.segments_mut(id) {
                    *segments = imported.segments;
                }
                warnings.extend(file.left_out(component));
                warnings.extend(imported.warnings);
                labels = Some(imported.said);
                Some((FieldKind::Labels, imported.changes))
            }
            OpenAs::Selection => {
                let imported = crate::document::apply::selection_import::import(
                    &subject,
                    &*subject.volume.source,
                    0.0,
                    0.0,
                    proceed,
                )?;
                warnings.extend(imported.warnings);
                selected_voxels = Some(imported.voxels);
                Some((FieldKind::Selection, imported.changes))
            }
        };
        let mut touched = Vec::new();
        if let Some((kind, changes)) = filled {
            let key = FieldKey::new(VolumeId::FIRST, kind);
            touched = changes.iter().map(|(index, _)| (key, *index)).collect();
            state.volume_mut(key.volume)?.field_mut(kind).swap(changes)?;
        }
        let keep = |folder: &Path| {
            let mut autosave = Autosave::unsaved(folder, &state)?;
            if open_as != OpenAs::Image || !touched.is_empty() {
                // What a keeper of unsaved work begins with is the file; labels, selection and colours are laid over it.
                let open = VolumeCommand::Open { path, component, frame, range, open_as };
                autosave.record(&Command::Volume(open), &state, &touched, true)?;
            }
            Ok::<_, KeepError>(autosave)
        };
        let autosave = match unsaved_in.map(keep) {
            Some(Ok(autosave)) => Some(autosave),
            Some(Err(error)) => {
                warnings.push(format!("unsaved work would not survive a crash: {error}"));
                None
            }
            None => None,
        };
        let poses = SavedPoses::at_rest(&state.scene, Poses::default());
        Ok(Self { state, poses, autosave, recovered: Recovered::default(), warnings, labels, selected_voxels })
    }

    /// What was read, and what is to be said of it.
    pub(crate) fn into_parts(self) -> (State, OpenedSaid) {
        let Self { state, warnings, labels, selected_voxels, .. } = self;
        let volume = state.at(None).map(|subject| crate::document::apply::ask::volume(&subject)).ok();
        (state, OpenedSaid { volume, labels, selected_voxels, warnings, recovered: None })
    }

    /// A project, with what its journal holds beyond the last save.
    ///
    /// # Errors
    /// If it is open elsewhere or damaged, the source fails, or `progress` said no.
    pub fn project(dir: &Path, progress: &(dyn Fn(f32) -> bool + Sync)) -> Result<Self, DocumentError> {
        Self::wanted(dir, Wanted::default(), progress)
    }

    /// The same with a word on the source of a linked density, or on an older generation. A folder that cannot be written to is
    /// looked at.
    ///
    /// # Errors
    /// As [`project`](Self::project).
    pub fn wanted(
        dir: &Path,
        wanted: Wanted<'_>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Self, DocumentError> {
        match Autosave::open_wanted(dir, wanted) {
            Err(error) if error.is_unwritable() => {
                let mut opened = Self::kept(None, Autosave::look_wanted(dir, wanted)?, progress)?;
                opened.warnings.push(format!(
                    "the project is open to look at: {error}; what is done is not noted and would not survive a crash, \
                     and can be saved to another folder only"
                ));
                Ok(opened)
            }
            opened => {
                let (autosave, kept) = opened?;
                Self::kept(Some(autosave), kept, progress)
            }
        }
    }

    /// The same to look at: whatever is done to it is noted nowhere, and others may have it open.
    ///
    /// # Errors
    /// As [`project`](Self::project).
    pub fn project_to_read(
        dir: &Path,
        wanted: Wanted<'_>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Self, DocumentError> {
        Self::kept(None, Autosave::look_wanted(dir, wanted)?, progress)
    }

    /// A document of [`recovery::list`](crate::document::journal::recovery::list).
    ///
    /// # Errors
    /// As [`project`](Self::project).
    pub fn lost(folder: &Path, id: &str, progress: &(dyn Fn(f32) -> bool + Sync)) -> Result<Self, DocumentError> {
        let (autosave, kept) = Autosave::recover(folder, id)?;
        Self::kept(Some(autosave), kept, progress)
    }

    fn kept(
        autosave: Option<Autosave>,
        kept: RestoredDocument,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Self, DocumentError> {
        let recovered = kept.recovered.clone();
        let linked = |origin: &Origin| Ok(io::open(&origin.path)?.source(origin.component, origin.frame, &|_| true)?);
        let mut poses = kept.poses.clone();
        let mut state = kept.into_state(linked, progress)?;
        let bounds = state.bounds();
        let mut mended = state.scene.mend(&state.volumes, &bounds);
        if let Err(error) = poses.parts.check(&state.scene.explosion) {
            mended.push(format!("{error}; all parts that no hand holds are at rest until forces take them"));
            poses = SavedPoses::default();
        }
        // Parts are checked already, and not anew with each of the past's views.
        let whole = state.subjects().next().map(|subject| Explosion::whole(subject.grid()).into());
        let explosion = whole.unwrap_or_else(|| Scene::empty().explosion);
        let plain = Scene { explosion, ..state.scene.clone() };
        state.past.retain(&plain, |scene| scene.check(&bounds).is_ok());
        let mut warnings = recovered.told.clone();
        warnings.extend(mended.into_iter().map(|what| format!("the project cannot be used as it was kept: {what}")));
        if let Some((path, reason)) = &recovered.set_aside {
            warnings.push(format!("the journal was damaged and put aside as {}: {reason}", path.display()));
        }
        Ok(Self { state, poses, autosave, recovered, warnings, labels: None, selected_voxels: None })
    }
}

impl Document {
    /// Shows what was read in place of what was open; past steps are forgotten. Answers as `volume.open` and `project.open` do.
    pub fn take(&mut self, opened: ReadDocument) -> Answer {
        let ReadDocument { state, poses, autosave, recovered, mut warnings, labels, selected_voxels } = opened;
        let volume = state.at(None).map(|subject| crate::document::apply::ask::volume(&subject)).ok();
        self.adopt(state);
        if let Some(state) = &self.state {
            self.motion.stand(state, poses);
        }
        self.autosave = autosave;
        self.unsaved = recovered.steps > 0;
        let stroke = self.finish_recovered(&recovered, &mut warnings);
        let Recovered { steps, last, torn_bytes, .. } = recovered;
        let anything = steps > 0 || !recovered.stroke.is_empty() || torn_bytes > 0;
        let recovered = anything.then_some(RecoveredSaid { steps, last, stroke, torn_bytes });
        Said::from(OpenedSaid { volume, labels, selected_voxels, warnings, recovered }).into()
    }

    /// Paints the stroke that was running when the document was lost as far as it had come; answers what became of it. It is tried
    /// once: the journal has it no more before it is begun, so that a stroke that brings the program down is not met at every
    /// start, and one that is cut off again is not painted twice.
    fn finish_recovered(&mut self, recovered: &Recovered, warnings: &mut Vec<String>) -> StrokeFate {
        if recovered.stroke.is_empty() {
            return StrokeFate::None;
        }
        self.no_stroke();
        let autosave = self.autosave.take();
        let resolved = Resolved { samples: recovered.stroke.clone(), ..Resolved::default() };
        let begun = self.begin_stroke(&recovered.stroke_volumes, resolved);
        self.autosave = autosave;
        match begun.and_then(|_| self.finish_stroke()) {
            Ok(_) => StrokeFate::Painted,
            Err(error) => {
                warnings.push(format!("the stroke that was running is lost: {error}"));
                self.drop_stroke();
                StrokeFate::Lost
            }
        }
    }
}

impl From<io::IoError> for DocumentError {
    fn from(error: io::IoError) -> Self {
        match error {
            io::IoError::Cancelled { .. } => Self::Stopped,
            other => Self::Io(other),
        }
    }
}
