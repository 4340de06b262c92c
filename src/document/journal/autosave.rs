//! Keeping an open document: each step into a journal, each save into a project, whatever is lost brought back.
//!
//! Owns the place where the document is kept: a project folder, or a recovery folder before the first save. Is told what was
//! done and never looks for itself. Dropping it leaves everything to be found at the next start, as a crash would.

use crate::document::command::Command;
use crate::document::command::answers::Saved;
use crate::document::command::files::DensityKeeping;
use crate::document::disk::error::KeepError;
use crate::document::disk::files::remove_dir;
use crate::document::disk::lock::Lock;
use crate::document::journal::Journal;
use crate::document::journal::generation::{journal_name, remove_older_journals, save_into};
use crate::document::journal::loaded::RestoredDocument;
use crate::document::journal::now::Beginning;
use crate::document::journal::poses_file::PosesFile;
use crate::document::journal::recovery;
use crate::document::journal::replay::{Replay, free_aside};
use crate::document::project::MANIFEST;
use crate::document::project::link::Link;
use crate::document::project::manifest::{DensityPlace, Manifest, VolumeRecord};
use crate::document::project::read::{Wanted, load, named, read_unsaved};
use crate::document::project::store::{Committed, Store, ToKeep};
use crate::document::scene::kept_poses::SavedPoses;
use crate::document::state::State;
use crate::explode::Poses;
use crate::io::FileMark;
use crate::paint::Sample;
use crate::volume::{BrickIndex, FieldKey, VolumeId};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Keeps one open document: its place on disk, the lock on it, and its journal.
#[derive(Debug)]
pub struct Autosave {
    journal: Journal,
    place: Place,
    /// Where parts stand, as far as it was told.
    poses: SavedPoses,
    poses_file: PosesFile,
}

#[derive(Debug)]
enum Place {
    Unsaved { dir: PathBuf, lock: Lock },
    Project(Box<Store>),
}

impl Autosave {
    /// Keeps a document that was never saved, from its present state on, below `state_dir`
    /// ([`recovery::state_dir`](crate::document::journal::recovery::state_dir)); the fields' edits so far are not kept.
    ///
    /// # Errors
    /// If the recovery folder or the file that was opened cannot be had.
    pub fn unsaved(state_dir: &Path, state: &State) -> Result<Self, KeepError> {
        let mut volumes = BTreeMap::new();
        for subject in state.subjects() {
            let nowhere = DensityPlace::nowhere(state, subject.id, subject.volume);
            if let Some(nowhere) = nowhere {
                volumes.insert(subject.id, VolumeRecord::of(subject.volume, nowhere, BTreeMap::new()));
                if let Some(before) = state.volumes.get(&subject.id.of_before())
                    && let Some(same) = DensityPlace::nowhere(state, subject.id.of_before(), before)
                {
                    volumes.insert(subject.id.of_before(), VolumeRecord::of(before, same, BTreeMap::new()));
                }
                continue;
            }
            let path = &subject.settings.origin.path;
            let link = match state.files.get(&subject.id) {
                Some(files) => Link::until_next_start(files.files())?,
                None => Link::until_next_start(&[FileMark::of(path).map_err(KeepError::io("read", path))?])?,
            };
            volumes.insert(subject.id, VolumeRecord::of(subject.volume, DensityPlace::Linked(link), BTreeMap::new()));
        }
        let (dir, lock) = recovery::create(state_dir)?;
        let start = || {
            let manifest = Manifest::of(0, state, &SavedPoses::at_rest(&state.scene, Poses::default()), volumes);
            crate::document::disk::files::write_new(&dir.join(MANIFEST), &manifest.json()?)?;
            Journal::create(&dir.join(recovery::JOURNAL), Beginning { scene: &state.scene, ..Beginning::of(&manifest) })
        };
        match start() {
            Ok(journal) => Ok(Self::over(journal, Place::Unsaved { dir, lock }, SavedPoses::default()).0),
            Err(error) => {
                remove_dir(&dir).unwrap_or_else(|e| tracing::warn!("{e}"));
                Err(error)
            }
        }
    }

    fn over(journal: Journal, place: Place, poses: SavedPoses) -> (Self, Option<SavedPoses>) {
        let (poses_file, beside) = PosesFile::beside(journal.path());
        (Self { journal, place, poses, poses_file }, beside)
    }

    /// Saves a document that nobody kept so far as a new project in `path`, and keeps it there. `poses` say where its parts stand.
    ///
    /// # Errors
    /// If the disk refuses, `path` is taken, or `progress` said no.
    pub fn create(
        path: &Path,
        state: &State,
        poses: &SavedPoses,
        density: Option<DensityKeeping>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<(Self, Saved), KeepError> {
        Self::create_all(path, &ToKeep::active(state, density), poses, progress)
    }

    /// The same of all that a document has to keep.
    pub(crate) fn create_all(
        path: &Path,
        kept: &ToKeep<'_>,
        poses: &SavedPoses,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<(Self, Saved), KeepError> {
        save_new(path, kept, poses, progress)
    }

    /// Opens a project as it was last kept: its current generation, and what the journal holds beyond it.
    ///
    /// # Errors
    /// If it is open elsewhere, or damaged. A damaged journal is set aside and told in
    /// [`Recovered`](crate::document::journal::loaded::Recovered); the generation opens without it.
    pub fn open(dir: &Path) -> Result<(Self, RestoredDocument), KeepError> {
        Self::open_wanted(dir, Wanted::default())
    }

    /// The same with a word on the source of a linked density, or on an older generation.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_wanted(dir: &Path, wanted: Wanted<'_>) -> Result<(Self, RestoredDocument), KeepError> {
        let (store, loaded) = Store::open(dir, wanted)?;
        let path = dir.join(journal_name(store.generation()));
        if loaded.is_current {
            remove_older_journals(dir, store.generation(), store.generation());
        }
        let beginning = || Beginning::of(&loaded.manifest);
        let mut set_aside = None;
        let resumed = match Journal::resume(&path, beginning()) {
            Err(error @ KeepError::Malformed { .. }) => {
                let aside = free_aside(&path);
                std::fs::rename(&path, &aside).map_err(KeepError::io("set aside", &path))?;
                set_aside = Some((aside, error.to_string()));
                None
            }
            other => other?,
        };
        let (journal, replay) = match resumed {
            Some(resumed) => resumed,
            None => (Journal::create(&path, beginning())?, Replay::default()),
        };
        let (mut autosave, beside) = Self::over(journal, Place::Project(Box::new(store)), SavedPoses::default());
        let mut document = RestoredDocument::new(loaded, replay, beside, &path)?;
        if set_aside.is_some() {
            document.recovered.set_aside = set_aside;
        }
        autosave.poses = document.poses.clone();
        Ok((autosave, document))
    }

    /// Reads a project as it was last kept, journal included, and leaves it alone: it may be open elsewhere or lie where nothing can
    /// be written.
    ///
    /// # Errors
    /// As [`open`](Self::open); of a damaged journal is told what is lost.
    pub fn look(dir: &Path) -> Result<RestoredDocument, KeepError> {
        Self::look_wanted(dir, Wanted::default())
    }

    /// The same with a word on the source of a linked density, or on an older generation.
    ///
    /// # Errors
    /// As [`look`](Self::look).
    pub fn look_wanted(dir: &Path, wanted: Wanted<'_>) -> Result<RestoredDocument, KeepError> {
        loop {
            let mut loaded = load(dir, wanted)?;
            let generation = loaded.manifest.generation;
            let path = dir.join(journal_name(generation));
            let replay = match Journal::look(&path, Beginning::of(&loaded.manifest)) {
                Err(error @ KeepError::Malformed { .. }) => {
                    loaded.told.push(format!("what was done after the last save is lost: {error}"));
                    None
                }
                other => other?,
            };
            // Whoever has it open may have saved meanwhile, and the journal went with it.
            if !loaded.is_current || named(dir)?.is_none_or(|now| now == generation) {
                let beside = PosesFile::beside(&path).1;
                return RestoredDocument::new(loaded, replay.unwrap_or_default(), beside, &path);
            }
        }
    }

    /// Brings back a document of [`recovery::list`](crate::document::journal::recovery::list) and goes on keeping it where it was.
    ///
    /// # Errors
    /// If it is gone or open elsewhere, or the file that it was opened from is not as it was.
    pub fn recover(state_dir: &Path, id: &str) -> Result<(Self, RestoredDocument), KeepError> {
        let dir = recovery::folder(state_dir, id)?;
        let lock = Lock::take(&dir)?;
        let loaded = read_unsaved(&dir)?;
        let path = dir.join(recovery::JOURNAL);
        let resumed = Journal::resume(&path, Beginning::of(&loaded.manifest))?;
        let (journal, replay) =
            resumed.ok_or_else(|| KeepError::io("open", &path)(std::io::ErrorKind::NotFound.into()))?;
        let (mut autosave, beside) = Self::over(journal, Place::Unsaved { dir, lock }, SavedPoses::default());
        let document = RestoredDocument::new(loaded, replay, beside, &path)?;
        autosave.poses = document.poses.clone();
        Ok((autosave, document))
    }

    /// Notes a command that is done. `command` has its places resolved to world millimetres; `touched` are the bricks whose texels
    /// it changed, an undo's as well. When it returns, a `synced` step survives a power cut; frames of an animation need not be
    /// (a crash of the program loses none of either). On failure the step stays in memory and is written before the next one.
    ///
    /// # Errors
    /// If the disk refuses, or the scene holds a number that JSON cannot say.
    pub fn record(
        &mut self,
        command: &Command,
        state: &State,
        touched: &[(FieldKey, BrickIndex)],
        synced: bool,
    ) -> Result<(), KeepError> {
        self.record_exchange(command, state, (touched, &BTreeSet::new()), synced)
    }

    /// The same of a command that exchanged volumes for others of their names.
    pub(crate) fn record_exchange(
        &mut self,
        command: &Command,
        state: &State,
        changed: (&[(FieldKey, BrickIndex)], &BTreeSet<VolumeId>),
        synced: bool,
    ) -> Result<(), KeepError> {
        self.journal.step(command, state, changed, synced)
    }

    /// Where it was told that parts stand.
    pub fn poses(&self) -> &SavedPoses {
        &self.poses
    }

    /// Notes where parts stand now, for the next save and, without waiting for the disk, for whoever finds the document after a crash.
    /// What cannot be noted is found again.
    pub fn note_poses(&mut self, poses: SavedPoses) {
        if poses != self.poses {
            self.poses_file.write(&poses).unwrap_or_else(|e| tracing::warn!("where parts stand is not noted: {e}"));
            self.poses = poses;
        }
    }

    /// Notes samples of the stroke that runs on these volumes, without waiting for the disk.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn samples(&mut self, volumes: &[VolumeId], samples: &[Sample]) -> Result<(), KeepError> {
        self.journal.samples(volumes, samples)
    }

    /// Notes that the running stroke was taken back, or ended and changed nothing.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn no_stroke(&mut self) -> Result<(), KeepError> {
        self.journal.no_stroke()
    }

    /// Saves: the next generation of the project, or a new project in `path`, which is the document's from then on. Not while a
    /// stroke runs. `density` says whether the project holds the density, as before if `None`. `progress` gets the share done and answers whether to go on.
    ///
    /// # Errors
    /// If the disk refuses, `path` is taken, or none is given for the first save. The project is then as it was before.
    pub fn save(
        &mut self,
        path: Option<&Path>,
        state: &State,
        density: Option<DensityKeeping>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Saved, KeepError> {
        self.save_all(path, &ToKeep::active(state, density), progress)
    }

    /// The same of all that a document has to keep.
    pub(crate) fn save_all(
        &mut self,
        path: Option<&Path>,
        kept: &ToKeep<'_>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Saved, KeepError> {
        let elsewhere = path.filter(|p| !self.project_dir().is_some_and(|dir| same_folder(p, dir)));
        match (&mut self.place, elsewhere) {
            (Place::Project(store), None) => {
                let Committed { saved, made, doubt } = save_into(store, kept, &self.poses, progress)?;
                self.poses_file = PosesFile::beside(made.path()).0;
                self.journal = made;
                doubt.map_or(Ok(saved), Err)
            }
            (Place::Unsaved { .. }, None) => Err(KeepError::NoPath),
            (_, Some(path)) => {
                let (next, saved) = save_new(path, kept, &self.poses, progress)?;
                // What the old place holds beyond its last save is in the new one.
                std::mem::replace(self, next).discard().unwrap_or_else(|e| tracing::warn!("{e}"));
                Ok(saved)
            }
        }
    }

    /// The project's folder, `None` before the first save.
    pub fn project_dir(&self) -> Option<&Path> {
        match &self.place {
            Place::Project(store) => Some(store.dir()),
            Place::Unsaved { .. } => None,
        }
    }

    /// Gives the folder to whoever opens it, until [`hold_again`](Self::hold_again). Nothing may be noted meanwhile.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn let_go(&self) -> Result<(), KeepError> {
        let (dir, lock) = self.folder();
        lock.release(dir)
    }

    /// Takes the folder again.
    ///
    /// # Errors
    /// If somebody else has it now.
    pub fn hold_again(&self) -> Result<(), KeepError> {
        let (dir, lock) = self.folder();
        lock.retake(dir)
    }

    fn folder(&self) -> (&Path, &Lock) {
        match &self.place {
            Place::Project(store) => (store.dir(), store.lock()),
            Place::Unsaved { dir, lock } => (dir, lock),
        }
    }

    /// Throws away what was noted since the document was opened or last saved, and leaves what a crash had left before.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn leave_as_found(self) -> Result<(), KeepError> {
        if !self.journal.found_anything() {
            return self.discard();
        }
        self.poses_file.leave_as_found().unwrap_or_else(|e| tracing::warn!("{e}"));
        self.journal.leave_as_found()
    }

    /// Throws away what was done since the last save; an unsaved document is gone.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn discard(self) -> Result<(), KeepError> {
        match self.place {
            Place::Project(_store) => {
                self.poses_file.remove().unwrap_or_else(|e| tracing::warn!("{e}"));
                let path = self.journal.path();
                std::fs::remove_file(path).map_err(KeepError::io("remove", path))
            }
            Place::Unsaved { dir, lock } => {
                let removed = remove_dir(&dir);
                drop(lock);
                removed
            }
        }
    }
}

/// Saves into a new project; without success the folder is as it was.
fn save_new(
    path: &Path,
    kept: &ToKeep<'_>,
    poses: &SavedPoses,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<(Autosave, Saved), KeepError> {
    let mut store = Store::create(path)?;
    match save_into(&mut store, kept, poses, progress) {
        Ok(Committed { doubt: Some(error), .. }) => Err(error),
        Ok(Committed { saved, made, .. }) => {
            Ok((Autosave::over(made, Place::Project(Box::new(store)), poses.clone()).0, saved))
        }
        Err(error) => {
            store.abandon();
            Err(error)
        }
    }
}

fn same_folder(a: &Path, b: &Path) -> bool {
    matches!((std::fs::canonicalize(a), std::fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
