//! Commands on the project on disk, and the journal that every other command is noted in.
//!
//! A document is kept where its keeper says: in its project, or before the first save in a recovery folder if one was named.
//! Whoever closes a document in order, or opens another, throws away what was not saved; whatever else ends it is a crash, and
//! all of it comes back.

use crate::document::Document;
use crate::document::apply::open::ReadDocument;
use crate::document::command::Command;
use crate::document::command::answers::{Answer, ForgottenSaid, LostSaid, Said, Saved, SavedSaid};
use crate::document::command::files::DensityKeeping;
use crate::document::command::files::ProjectCommand;
use crate::document::error::DocumentError;
use crate::document::history::step::Refreshed;
use crate::document::journal::autosave::Autosave;
use crate::document::journal::recovery;
use crate::document::paths::check_target;
use crate::document::project::read::Wanted;
use crate::document::project::store::ToKeep;
use std::path::{Path, PathBuf};

impl Document {
    /// Notes unsaved documents in a folder, from the next that is opened on.
    pub fn keep_unsaved_in(&mut self, folder: PathBuf) {
        self.unsaved_in = Some(folder);
    }

    /// Where the first save goes if it names no place.
    pub fn save_to(&mut self, folder: PathBuf) {
        self.save_to = Some(folder);
    }

    /// The project's folder, once saved.
    pub fn project_dir(&self) -> Option<&Path> {
        self.autosave.as_ref().and_then(Autosave::project_dir)
    }

    /// Whether steps are noted on disk as they are done.
    pub fn is_kept(&self) -> bool {
        self.autosave.is_some()
    }

    /// A document with nothing open that keeps what it must where this one does.
    pub fn successor(&self) -> Self {
        let (watch, unsaved_in) = (self.watch.clone(), self.unsaved_in.clone());
        Self { watch, unsaved_in, touch: self.touch.clone(), history: self.history.successor(), ..Self::default() }
    }

    /// Whether steps were done, undone or brought back since the last save.
    pub fn is_unsaved(&self) -> bool {
        self.unsaved
    }

    /// What is wrong with the file that a linked project's density is read from: it is not the one that was painted on. With `wait`
    /// its hash is waited for; without, `None` also while nobody knows.
    pub fn source_trouble(&self, wait: bool) -> Option<String> {
        let mut compared = self.state.as_ref()?.files.values().filter(|files| files.is_compared());
        compared.find_map(|files| match wait {
            true => files.hashes(&|| true).err().map(|error| error.to_string()),
            false => files.trouble(),
        })
    }

    /// Whether the hash of a linked project's density is still being compared.
    pub fn is_comparing(&self) -> bool {
        self.state.as_ref().is_some_and(|s| s.files.values().any(|f| f.is_compared() && f.is_pending()))
    }

    /// Closes in order: what was not saved is thrown away.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn discard_unsaved(mut self) -> Result<(), DocumentError> {
        match self.autosave.take() {
            Some(autosave) => Ok(autosave.discard()?),
            None => Ok(()),
        }
    }

    /// Closes in order: what this program did and did not save is thrown away, what an earlier one left behind when it crashed
    /// stays to be found.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn leave_as_found(mut self) -> Result<(), DocumentError> {
        match self.autosave.take() {
            Some(autosave) => Ok(autosave.leave_as_found()?),
            None => Ok(()),
        }
    }

    pub(crate) fn project(&mut self, command: &ProjectCommand) -> Result<Answer, DocumentError> {
        match command {
            ProjectCommand::Open { path, source, generation } => {
                let watch = self.watch.clone();
                let wanted = Wanted { source: source.as_deref(), generation: *generation };
                let opened = self.beside(path, || ReadDocument::wanted(path, wanted, &|x| watch.proceed(x)))?;
                Ok(self.take(opened))
            }
            ProjectCommand::Save { path, density } => {
                let watch = self.watch.clone();
                let saved = self.save(path.as_deref(), *density, &|x| watch.proceed(x))?;
                let path = self.project_dir().map(|dir| dir.display().to_string());
                Ok(Said::from(SavedSaid { saved, path }).into())
            }
            ProjectCommand::Lost {} => {
                let lost = recovery::list(&self.recovery_folder()?)?;
                Ok(Said::from(LostSaid { lost }).into())
            }
            ProjectCommand::Recover { id } => {
                let watch = self.watch.clone();
                let opened = ReadDocument::lost(&self.recovery_folder()?, id, &|x| watch.proceed(x))?;
                Ok(self.take(opened))
            }
            ProjectCommand::Forget { id } => {
                recovery::discard(&self.recovery_folder()?, id)?;
                Ok(Said::from(ForgottenSaid { forgotten: id.clone() }).into())
            }
        }
    }

    /// Saves: the next generation of the project, or a new project in `path`. `progress` gets the share done and answers whether
    /// to go on.
    ///
    /// # Errors
    /// If the disk refuses, `path` is taken, or none is given for the first save.
    pub fn save(
        &mut self,
        path: Option<&Path>,
        density: Option<DensityKeeping>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Saved, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let first = self.project_dir().is_none();
        let path = path.or(if first { self.save_to.as_deref() } else { None });
        if let Some(path) = path {
            check_target(path, &state.files)?;
        }
        let poses = self.motion.kept(state);
        let kept = ToKeep { set_aside: self.history.set_aside(), ..ToKeep::active(state, density) };
        let saved = match (&mut self.autosave, path) {
            (Some(autosave), path) => {
                autosave.note_poses(poses);
                autosave.save_all(path, &kept, progress)?
            }
            (None, Some(path)) => {
                let (autosave, saved) = Autosave::create_all(path, &kept, &poses, progress)?;
                self.autosave = Some(autosave);
                saved
            }
            (None, None) => return Err(crate::document::disk::error::KeepError::NoPath.into()),
        };
        self.unsaved = false;
        Ok(saved)
    }

    /// Notes a command that is done; answers a warning if it could not be. A `synced` one survives a power cut.
    pub(crate) fn note(&mut self, command: &Command, refreshed: &Refreshed, synced: bool) -> Option<String> {
        let (autosave, state) = (self.autosave.as_mut()?, self.state.as_ref()?);
        let changed = (&refreshed.bricks[..], &refreshed.exchanged);
        let noted = autosave.record_exchange(command, state, changed, synced);
        noted.err().map(|e| format!("this step is done but not safe from a crash yet: {e}"))
    }

    /// Notes where parts stand, unless they stand where they did.
    pub(crate) fn note_poses(&mut self) {
        let (Some(autosave), Some(state)) = (&mut self.autosave, &self.state) else { return };
        if autosave.poses().parts != *self.motion.poses() {
            autosave.note_poses(self.motion.kept(state));
        }
    }

    /// Another document is open: this one is closed in order, as by [`leave_as_found`](Self::leave_as_found). Whoever opens says
    /// before what becomes of unsaved work; what was not wanted must not come back as if it had been lost.
    pub(crate) fn leave_place(&mut self) {
        if let Some(Err(error)) = self.autosave.take().map(Autosave::leave_as_found) {
            tracing::warn!("{error}");
        }
    }

    /// Opens what may be the project that is open here: its folder is let go of meanwhile. If it cannot be opened, this document
    /// stays, and goes on being kept.
    fn beside(
        &mut self,
        path: &Path,
        open: impl FnOnce() -> Result<ReadDocument, DocumentError>,
    ) -> Result<ReadDocument, DocumentError> {
        let same = |dir: &Path| matches!((dir.canonicalize(), path.canonicalize()), (Ok(a), Ok(b)) if a == b);
        let Some(autosave) = self.autosave.take_if(|k| k.project_dir().is_some_and(same)) else { return open() };
        if let Err(error) = autosave.let_go() {
            self.autosave = Some(autosave);
            return Err(error.into());
        }
        let opened = open();
        match (&opened, autosave.hold_again()) {
            (Err(_), Ok(())) => self.autosave = Some(autosave),
            (Err(why), Err(gone)) => {
                return Err(DocumentError::NotNow(format!(
                    "{why}; and what is done from here on is not safe from a crash until it is saved elsewhere: {gone}"
                )));
            }
            (Ok(_), _) => {}
        }
        opened
    }

    fn recovery_folder(&self) -> Result<PathBuf, DocumentError> {
        match &self.unsaved_in {
            Some(folder) => Ok(folder.clone()),
            None => Ok(recovery::state_dir()?),
        }
    }
}
