//! The document: what is open, what can be done to it, and how it is kept.
//!
//! One command set. Buttons, shortcuts, tools, scripts and tests all call [`Document::apply`] with a [`Command`]; every command
//! answers with what it did, and one that fails has changed nothing. What it does to the scene is in `reduce`, what beyond
//! that in `apply`; what it means for everything around it in `command::effects`. Views and the brush are
//! tools: they are saved, and undo leaves both alone. Views, looks, layers and window have a past of their own (`view.back`). Everything
//! else is undone.

mod apply;
mod command;
pub mod disk;
mod error;
mod family;
mod frame;
mod history;
pub(crate) mod journal;
pub(crate) mod live;
pub(crate) mod look_rows;
pub(crate) mod paths;
mod place;
pub mod project;
mod reduce;
mod scene;
mod spared;
mod state;
mod subject;
mod watch;

pub use apply::label::LabelAnchor;
pub use apply::open::ReadDocument;
pub use command::annotations::*;
pub use command::answers::Saved;
pub use command::brush::*;
pub use command::component::*;
pub use command::files::*;
pub use command::parts::*;
pub use command::resolved::{FileRead, ResolvedCommand};
pub use command::sub_volumes::*;
pub use command::views::*;
pub use command::*;
pub use command::{answers, answers_ask, effects};
pub use disk::error::KeepError;
pub use disk::source_files::SourceFiles;
pub use error::DocumentError;
pub use frame::SELECTION_COLOUR;
pub use history::spill::remove_dead_history;
pub use history::{DEFAULT_BUDGET_BYTES, History};
pub use journal::autosave::Autosave;
pub use journal::loaded::{Recovered, RestoredDocument, RestoredVolume};
pub use journal::recovery;
pub use live::aim::Aim;
pub use live::contact::{Contact, ContactFeed, ContactField, ContactForce};
pub use paths::at_home;
pub use project::read::{LoadedDensity, Wanted};
pub use project::source::ZarrSource;
pub use reduce::{Changed, Ground};
pub use scene::annotations::{
    Align, Anchor, Annotation, AnnotationId, Annotations, Content, Directions, PatternKind, Tracing,
};
pub use scene::cutaways::{Cutaway, CutawayId, Cutaways, Outline, Rim, Spared};
pub use scene::focus::{FarMatter, ViewFocus};
pub use scene::kept_poses::SavedPoses;
pub use scene::labels::{Label, LabelId, LabelStyle, Labels, Named};
pub use scene::past::{Past, PastOf};
pub use scene::shared::Shared;
pub use scene::slice_plane::{SlicePlane, side_letter};
pub use scene::volumes::*;
pub use scene::*;
pub use state::State;
pub use subject::Subject;
pub use watch::Watch;

use crate::document::apply::painting::Running;
use crate::document::command::answers::{Answer, Said, StepSaid};
use crate::document::command::effects::{Noted, Remembered};
use crate::document::history::edit::Edit;
use crate::document::history::step::Refreshed;
use crate::document::live::graphics::Graphics;
use crate::document::live::laid::Laid;
use crate::document::live::motion::Motion;
use crate::document::live::poles::Poles as SegmentPoles;
use crate::document::live::windows::Windows;
use crate::document::scene::past::PastGroup;
use crate::explode::Poses;
use crate::volume::{Grid, Histogram};
use std::path::PathBuf;

/// What is open, with its history, its keeper and all that can be made again from it.
#[derive(Debug, Default)]
pub struct Document {
    state: Option<State>,
    history: History,
    /// What the open group of history has changed of views and looks.
    past_group: PastGroup,
    graphics: Graphics,
    motion: Motion,
    laid: Laid,
    windows: Windows,
    poles: SegmentPoles,
    running: Option<Running>,
    aim: Option<Aim>,
    touch: ContactFeed,
    watch: Watch,
    autosave: Option<Autosave>,
    unsaved_in: Option<PathBuf>,
    save_to: Option<PathBuf>,
    unsaved: bool,
    revision: u64,
    opening: u64,
}

impl Document {
    /// Nothing open.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a volume that was read elsewhere as a new, unsaved document; past steps are forgotten.
    pub fn adopt(&mut self, state: State) {
        self.drop_stroke();
        self.state = Some(state);
        self.opening += 1;
        self.graphics.forget();
        self.motion.forget();
        self.laid.finds.forget();
        self.windows.finds.forget();
        self.poles.forget();
        self.touch.forget();
        self.aim = None;
        self.leave_place();
        self.unsaved = false;
        self.history.clear();
        self.past_group = PastGroup::default();
        self.revision += 1;
    }

    /// What is open.
    pub fn state(&self) -> Option<&State> {
        self.state.as_ref()
    }

    /// Steps that can be undone and redone.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Where older steps of history go; the system's temporary folder unless said otherwise. Forgets past steps.
    pub fn keep_history_in(&mut self, folder: PathBuf) {
        self.history = History::new(folder);
    }

    /// Says who is told how far a long command has got, and may stop it: opening, saving, exporting, importing, settling.
    pub fn set_watch(&mut self, watch: Watch) {
        self.watch = watch;
    }

    /// Changes whenever the document did: whoever shows it draws again.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Tells documents apart that were open one after another: another number for each.
    pub fn opening(&self) -> u64 {
        self.opening
    }

    /// Does a command and answers what it did; `step` names the new step of history, or is null.
    ///
    /// # Errors
    /// If the command cannot be done; nothing was changed then.
    pub fn apply(&mut self, command: Command) -> Result<Answer, DocumentError> {
        let command = command.at_home()?;
        if self.running.is_some() && command.effects().ends_stroke {
            self.finish_stroke()?;
        }
        let command = self.in_numbers(command)?;
        let answer = match &command {
            Command::Stroke(stroke) => return self.stroke(stroke),
            Command::Render(render) => return Ok(Answer::from(self.render(render)?)),
            Command::Ask(question) => return Ok(Answer::from(self.ask(question)?)),
            Command::Project(project) => self.project(project)?,
            Command::Volume(volume) => self.volume(volume)?,
            Command::SubVolume(command) => self.sub_volume(command)?,
            Command::History(history) => self.undo_redo(history)?,
            // What they do to the scene is all they do.
            Command::Transfer(_) | Command::Brush(_) | Command::Part(_) => {
                self.record(&command, |_, said, _| Ok(said))?
            }
            Command::Label(_) => self.record(&command, |_, said, _| Ok(said))?,
            Command::Annotation(_) => self.record(&command, |document, said, _| document.annotated(said))?,
            Command::Cutaway(_) => self.record(&command, |document, said, _| document.opened(said))?,
            Command::View(view) => self.record(&command, |document, said, _| document.view(view, said))?,
            Command::Segment(segment) => {
                self.record(&command, |document, said, edit| document.segment(segment, said, edit))?
            }
            Command::Component(component) => {
                self.record(&command, |document, _, edit| document.component(component, edit))?
            }
            Command::Selection(selection) => {
                self.record(&command, |document, said, edit| document.selection(selection, said, edit))?
            }
            Command::Explosion(explosion) => {
                self.record(&command, |document, said, _| document.explosion(explosion, said))?
            }
        };
        self.revision += 1;
        Ok(answer)
    }

    /// Does a command that changes what is open, and makes a step of what it changed: first what it does to the scene, then what is
    /// `beyond` it and needs voxels, disk or GPU, which is given what is said of the scene and says what is answered.
    fn record(
        &mut self,
        command: &Command,
        beyond: impl FnOnce(&mut Self, Said, &mut Edit) -> Result<Said, DocumentError>,
    ) -> Result<Answer, DocumentError> {
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        let mut edit = Edit::new(Some(state));
        let (views, looks) = ((*state.scene.views).clone(), state.scene.looks());
        let bounds = state.bounds();
        let ground = match state.at(command.volume()) {
            // A sub-volume is measured where that is asked for, and not by every command.
            Ok(subject) if command.reads_values() => match subject.measured() {
                Ok(Some(own)) => Ok((*subject.grid(), own.histogram.clone())),
                Ok(None) => Ok((*subject.grid(), subject.histogram.clone())),
                Err(error) => Err(error),
            },
            Ok(subject) => Ok((*subject.grid(), subject.histogram.clone())),
            // Cameras and tools need nothing that is in a volume.
            Err(DocumentError::NoVolume) if !command.needs_volume() => {
                Ok((Grid::of_nothing(&bounds), Histogram::default()))
            }
            Err(error) => Err(error),
        };
        let changed = match ground {
            Ok((grid, histogram)) => {
                let ground = Ground { grid: &grid, bounds, histogram: &histogram, poses: self.motion.poses() };
                state.scene.apply(command, &ground)
            }
            // Volumes come to a document that has none.
            Err(_) if matches!(command, Command::Volume(_)) => Ok(Changed::default()),
            Err(error) => Err(error),
        };
        let said = changed.and_then(|changed| {
            edit.name(changed.name);
            beyond(self, changed.said, &mut edit)
        });
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        let said = match said {
            Ok(said) => said,
            Err(error) => {
                let refreshed = edit.roll_back(state)?;
                self.mirror(&refreshed);
                return Err(error);
            }
        };
        let (voxels, bricks) = edit.counts();
        let mut stand_anew = edit.before().is_some_and(|before| {
            let remember = !self.history.group_has_explosion();
            self.motion.decided(&before.explosion, &state.scene.explosion, remember)
        });
        edit.made_by(ResolvedCommand::plain(command.clone()));
        let called = edit.called().to_owned();
        let (step, refreshed) = edit.finish(state);
        self.mirror(&refreshed);
        let effects = command.effects();
        let new_looks = self.remember(effects.past, &called, views, looks);
        let step_said = StepSaid {
            step: step.as_ref().map(|s| s.name.clone()),
            voxels_changed: (bricks > 0).then_some(voxels),
            bricks_touched: (bricks > 0).then_some(bricks),
        };
        let mut answer = Answer { said, step: Some(step_said), trouble: Vec::new() };
        let synced = step.is_some() || new_looks;
        self.unsaved |= new_looks;
        if let Some(step) = step {
            self.unsaved = true;
            answer.trouble.extend(self.history.push(step)?);
        }
        match effects.journal {
            // What the simulation finds was decided by nobody: frames of an animation are worth nothing, where it ends is noted
            // for whoever comes after a crash.
            Noted::Never => stand_anew = !answer.said.is_moving(),
            _ => answer.trouble.extend(self.note(command, &refreshed, synced)),
        }
        if stand_anew {
            self.note_poses();
        }
        Ok(answer)
    }

    /// Notes what a command changed of views and looks. Answers whether looks are other ones.
    fn remember(&mut self, past: Remembered, called: &str, before: Views, looks: Looks) -> bool {
        let Some(State { scene, past: behind, .. }) = &mut self.state else { return false };
        let new_looks = !looks.are_of(scene);
        let mut group = self.history.in_group().then_some(&mut self.past_group);
        match past {
            Remembered::Nothing => return new_looks,
            Remembered::View => behind.viewed(called, before, &scene.views, group.as_deref_mut()),
            Remembered::Looks => {}
        }
        if new_looks {
            behind.looked(called, looks, group);
        }
        new_looks
    }

    /// Reads ahead what the explosion's first move would wait for, and measures the active volume if it is a sub-volume of few samples; for a
    /// moment in which there is nothing else to do. Answers whether it measured.
    ///
    /// # Errors
    /// If the source fails.
    pub fn prepare(&mut self) -> Result<bool, DocumentError> {
        /// So many are measured within a tenth of a second or two.
        const FEW: u64 = 1 << 22;
        let (Some(state), false) = (&self.state, self.is_painting()) else { return Ok(false) };
        self.motion.prepare(state)?;
        let new = |subject: &Subject<'_>| {
            subject.grid().voxel_count() <= FEW && subject.volume.density.known_measures().is_none()
        };
        match state.at(None).ok().filter(new) {
            Some(subject) => Ok(subject.measured()?.is_some()),
            None => Ok(false),
        }
    }

    /// Where the parts stand: what the simulation found, or a hand holds. Nothing of it is in the scene.
    pub fn poses(&self) -> &Poses {
        self.motion.poses()
    }

    /// Whether parts do not stand where forces would have them now: then `explosion.step` moves them. What their rest depends on,
    /// and a stroke that explosion points follow, says it; no command does.
    pub fn must_move(&self) -> bool {
        let Some(state) = &self.state else { return false };
        self.motion.must_move(state) || (state.scene.explosion.degree > 0.0 && self.has_stroke_to_follow())
    }

    /// Hands changed voxels on to their mirrors.
    fn mirror(&mut self, refreshed: &Refreshed) {
        if let Some(state) = &self.state {
            self.graphics.mirror(state, refreshed);
            self.motion.mirror(state, refreshed);
            self.laid.finds.mirror(state, refreshed);
            self.windows.finds.mirror(state, refreshed);
            self.poles.mirror(refreshed);
        }
    }

    fn open(&self) -> Result<&State, DocumentError> {
        self.state.as_ref().ok_or(DocumentError::NothingOpen)
    }

    fn open_mut(&mut self) -> Result<&mut State, DocumentError> {
        self.state.as_mut().ok_or(DocumentError::NothingOpen)
    }
}
