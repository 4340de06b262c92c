//! The thread that owns the document: does commands in order, lets parts move, draws what is seen.
//!
//! Commands come first; pictures are drawn when none waits, one view at a time, so that a stroke's samples never queue behind a
//! picture for longer than one takes. Knows egui only to wake the window.

use crate::document::answers::{Answer, Said};
use crate::document::effects::{Effects, Redraws};
use crate::document::{
    Command, Document, DocumentError, ExplosionCommand, HistoryCommand, KeepError, LabelAnchor, Place, Question,
    RenderCommand, ViewName,
};
use crate::interact::readout;
use crate::math::DVec2;
use crate::ui::thread::progress::{PercentTold, doing};
use crate::ui::thread::rescue::{after_failure, way_out};
use crate::ui::thread::session::{Picture, Report, Request, Session, Severity, Snapshot, WorkerEnd};
use crate::ui::thread::snapshot::{label_anchors, open_document, sketch};
use crate::ui::thread::view_scheduler::ViewScheduler;
use crate::volume::Histogram;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Steps of 1/60 s that parts do between two pictures at most.
const MOST_STEPS: u32 = 4;
/// Milliseconds after which a picture is due: a step that measures what hides the selection draws a picture of its own.
const STEPS_MS: u128 = 30;
/// Names pictures among what can be refused.
const PICTURE: &str = "picture";
/// How often a hash that is being taken is looked after.
const LOOK: Duration = Duration::from_millis(200);
/// As good as at once.
const SOON: Duration = Duration::from_millis(1);

/// Starts it; the session is the window's end. The thread ends when the window drops it.
///
/// # Errors
/// If the system gives no thread.
pub fn spawn(mut document: Document, wake: egui::Context) -> std::io::Result<(Session, JoinHandle<()>)> {
    let (session, worker_end) = Session::pair();
    let moving = document.must_move();
    let progress = PercentTold::new(worker_end.stop.clone());
    document.set_watch(progress.watch(worker_end.reports.clone(), wake.clone()));
    let worker = Worker {
        worker_end,
        progress,
        scheduler: ViewScheduler::default(),
        document,
        wake,
        serial: 0,
        shown: Vec::new(),
        held: None,
        probe: None,
        gpu: None,
        moving,
        histogram: None,
        labels: Arc::default(),
        settled: None,
        refused: BTreeSet::new(),
        told: None,
        source_trouble: None,
        refining: false,
    };
    let thread = std::thread::Builder::new().name("document".into()).spawn(move || worker.run())?;
    Ok((session, thread))
}

enum Next {
    Go,
    Quit,
    Gone,
}

struct Worker {
    worker_end: WorkerEnd,
    progress: PercentTold,
    scheduler: ViewScheduler,
    document: Document,
    wake: egui::Context,
    serial: u64,
    shown: Vec<ViewName>,
    /// The view under the hand.
    held: Option<ViewName>,
    probe: Option<(ViewName, DVec2, [u32; 2])>,
    gpu: Option<Result<String, String>>,
    moving: bool,
    /// The open document's: another one for another document, also where the volume is the same.
    histogram: Option<Arc<Histogram>>,
    /// What the labels that are shown named last.
    labels: Arc<Vec<LabelAnchor>>,
    /// Revision of the document that what is relaxed was last found for.
    settled: Option<u64>,
    /// What was refused and has not worked since, as `noun.verb`.
    refused: BTreeSet<String>,
    /// Revision and serial of the last snapshot sent.
    told: Option<(u64, u64, bool)>,
    /// What was said last of the file of a linked project.
    source_trouble: Option<String>,
    /// What was said last of the 3D view.
    refining: bool,
}

impl Worker {
    fn run(mut self) {
        self.tell();
        self.gpu = Some(self.document.describe_gpu());
        self.told = None;
        self.tell();
        loop {
            // Whatever fails in here, the journal on disk has every step up to it, and the window goes on.
            match catch_unwind(AssertUnwindSafe(|| self.turn())) {
                Ok(Next::Go) => {}
                Ok(Next::Quit) => {
                    if let Err(error) = self.document.discard_unsaved() {
                        tracing::warn!("{error}");
                    }
                    return;
                }
                Ok(Next::Gone) => return,
                Err(payload) => self.fallen(payload.as_ref()),
            }
        }
    }

    fn turn(&mut self) -> Next {
        let next = self.take_requests();
        if !matches!(next, Next::Go) {
            return next;
        }
        self.document.set_motion(self.rough());
        if self.moving {
            // A step may have to measure what hides the selection; what was done is told before.
            self.tell();
            self.step();
        }
        self.tell();
        if let Err(error) = self.document.renew_touch() {
            tracing::warn!("nothing can be felt: {error}");
        }
        self.tell_source();
        self.tell_refining();
        self.answer_probe();
        self.draw();
        self.tell_refining();
        Next::Go
    }

    /// Closes a document in which something has failed: nobody knows what it holds now. What is on disk is left to be found.
    fn fallen(&mut self, payload: &(dyn std::any::Any + Send)) {
        let (text, offer) = after_failure(&self.document, payload);
        let next = self.document.successor();
        let document = std::mem::replace(&mut self.document, next);
        // What failed once may fail again.
        let _again = catch_unwind(AssertUnwindSafe(|| drop(document)));
        self.scheduler = ViewScheduler::default();
        (self.moving, self.held, self.probe) = (false, None, None);
        (self.histogram, self.told, self.source_trouble) = (None, None, None);
        (self.labels, self.settled) = (Arc::default(), None);
        self.refused.clear();
        self.report(Report::Finished);
        self.tell_refining();
        self.tell();
        self.report(Report::Message(Severity::Error, text));
        if let Some(offer) = offer {
            self.report(Report::Offer(Box::new(offer)));
        }
    }

    /// Says once that the file of a linked project is not the one that was painted on.
    fn tell_source(&mut self) {
        let trouble = self.document.source_trouble(false);
        if trouble != self.source_trouble {
            self.source_trouble.clone_from(&trouble);
            if let Some(text) = trouble {
                self.report(Report::Message(Severity::Error, text));
            }
        }
    }

    /// Does what waits; sleeps if there is nothing else to do.
    fn take_requests(&mut self) -> Next {
        if !self.moving && self.probe.is_none() && !self.scheduler.has_work(&self.document, &self.shown, self.rough()) {
            let next = match self.worker_end.requests.try_recv() {
                Err(TryRecvError::Empty) => {
                    match self.document.prepare() {
                        // There is something new to be told.
                        Ok(true) => {
                            self.told = None;
                            return Next::Go;
                        }
                        Ok(false) if self.settle() => return Next::Go,
                        Ok(false) => {}
                        Err(error) => tracing::warn!("{error}"),
                    }
                    // While a hash is taken somebody has to look whether it is the right one.
                    if self.document.is_comparing() || self.document.source_trouble(false) != self.source_trouble {
                        self.worker_end.requests.recv_timeout(LOOK)
                    } else {
                        self.worker_end.requests.recv().map_err(|_| RecvTimeoutError::Disconnected)
                    }
                }
                next => next.map_err(|_| RecvTimeoutError::Disconnected),
            };
            match next {
                Ok((serial, request)) => {
                    if !self.take(serial, request) {
                        return Next::Quit;
                    }
                }
                Err(RecvTimeoutError::Timeout) => return Next::Go,
                Err(RecvTimeoutError::Disconnected) => return Next::Gone,
            }
        }
        loop {
            match self.worker_end.requests.try_recv() {
                Ok((serial, request)) => {
                    if !self.take(serial, request) {
                        return Next::Quit;
                    }
                }
                Err(TryRecvError::Empty) => return Next::Go,
                Err(TryRecvError::Disconnected) => return Next::Gone,
            }
        }
    }

    /// Lets what lies on surfaces relax; answers whether the 3D view is another one now. What cannot be found is sought once.
    fn settle(&mut self) -> bool {
        if self.settled == Some(self.document.revision()) {
            return false;
        }
        let changed = self.document.settle_layers();
        self.settled = Some(self.document.revision());
        if changed {
            self.scheduler.note(Redraws::THREE_D);
        }
        changed
    }

    /// `false`: the window was closed in order.
    fn take(&mut self, serial: u64, request: Request) -> bool {
        self.serial = serial;
        match request {
            Request::Apply(command) => self.apply(command),
            Request::Probe { view, px, size } => self.probe = Some((view, px, size)),
            Request::Show(views) => self.shown = views,
            Request::Sketch(command) => self.sketch(command),
            Request::Held(held) => self.held = held,
            Request::Aim(aim) => {
                if self.document.aim(aim) {
                    self.scheduler.note(Redraws::THREE_D);
                }
            }
            Request::Quit => return false,
        }
        true
    }

    /// Whether pictures may be coarse.
    fn rough(&self) -> bool {
        self.held.is_some() || self.moving
    }

    fn draw(&mut self) {
        let rough = self.rough();
        match self.scheduler.draw(&mut self.document, &self.shown, self.held, rough) {
            Ok(Some(picture)) => {
                self.worked(PICTURE);
                self.report(Report::Picture(Box::new(Picture { serial: self.serial, ..picture })));
            }
            Ok(None) => {}
            Err(error) => {
                self.refused.insert(PICTURE.into());
                self.report(Report::Complaint(PICTURE.into(), error.to_string()));
            }
        }
    }

    /// Says when the 3D view begins and ceases to show less than all there is.
    fn tell_refining(&mut self) {
        let now = self.scheduler.is_refining(&self.document, &self.shown);
        if std::mem::replace(&mut self.refining, now) != now {
            self.report(Report::Refining(now));
        }
    }

    fn apply(&mut self, command: Command) {
        let effects = command.effects();
        self.note(&effects);
        let started = doing(&command, effects.lasts);
        if let Some(what) = &started {
            self.progress.begin();
            self.report(Report::Started(what.clone()));
        }
        let result = self.document.apply(command.clone());
        if started.is_some() {
            self.report(Report::Finished);
        }
        match result {
            Ok(answer) => {
                if effects.opens {
                    self.histogram = None;
                }
                // A script moves parts when it says so; the window lets them follow whatever is done.
                self.moving = self.document.must_move();
                self.say_warnings(&answer);
                if let Some(nothing) = answer.nothing() {
                    self.report(Report::Nothing(nothing.to_owned()));
                }
                if !self.refused.is_empty() {
                    self.worked(effects.name);
                }
                if effects.is_awaited {
                    self.report(Report::Done(Box::new(command), Box::new(answer)));
                }
            }
            // A group that was closed by something else is no news.
            Err(DocumentError::NotNow(_))
                if matches!(command, Command::History(HistoryCommand::End {} | HistoryCommand::Cancel {})) => {}
            Err(DocumentError::Stopped) => {
                let what = started.map_or_else(String::new, |what| format!("{what}: "));
                self.report(Report::Message(Severity::Note, format!("{what}{}", DocumentError::Stopped)));
            }
            Err(error @ DocumentError::Keep(KeepError::Stopped)) => {
                self.report(Report::Message(Severity::Note, error.to_string()));
            }
            Err(error) => {
                if let Some(offer) = way_out(&command, &error) {
                    self.report(Report::Offer(Box::new(offer)));
                }
                self.refused.insert(effects.name.into());
                self.report(Report::Refused(Box::new(command), error.to_string()));
            }
        }
    }

    /// Takes in which pictures a command that is about to be done may change; one that ends a stroke lays its last dab.
    fn note(&mut self, effects: &Effects) {
        let ends = effects.ends_stroke && self.document.is_painting();
        self.scheduler.note(if ends { Redraws::ALL } else { effects.redraws });
    }

    /// What was refused before has worked now.
    fn worked(&mut self, topic: &str) {
        if self.refused.remove(topic) {
            self.report(Report::Mended(topic.to_owned()));
        }
    }

    fn say_warnings(&self, answer: &Answer) {
        for warning in answer.warnings() {
            self.report(Report::Message(Severity::Warning, readout::sentence(warning)));
        }
    }

    fn sketch(&mut self, asked: RenderCommand) {
        let drawn = sketch(&mut self.document, &asked);
        self.report(Report::Sketch(asked, drawn));
    }

    /// Lets the parts move on.
    fn step(&mut self) {
        let begun = Instant::now();
        // The first alone, to see whether there is time for the rest.
        for steps in [1, MOST_STEPS - 1] {
            let step = Command::Explosion(ExplosionCommand::Step { steps });
            self.note(&step.effects());
            match self.document.apply(step) {
                Ok(_) => self.moving = self.document.must_move(),
                Err(error) => {
                    self.moving = false;
                    self.report(Report::Complaint(PICTURE.into(), error.to_string()));
                }
            }
            if !self.moving || begun.elapsed().as_millis() > STEPS_MS {
                return;
            }
        }
    }

    fn answer_probe(&mut self) {
        let Some((view, px, size)) = self.probe.take() else { return };
        let at = Place::Pixel { view, px: px.to_array(), size: Some(size) };
        // Nothing under the pointer is an answer too.
        let voxel =
            match self.document.apply(Command::Ask(Question::Voxel { at, volume: None })).map(|answer| answer.said) {
                Ok(Said::Voxel(voxel)) => Some(*voxel),
                Ok(_) | Err(_) => None,
            };
        self.report(Report::Probe(voxel));
    }

    /// Sends a snapshot if anything is new.
    fn tell(&mut self) {
        let now = (self.document.revision(), self.serial, self.moving);
        if self.told == Some(now) {
            return;
        }
        self.labels = label_anchors(&mut self.document, &self.labels);
        let open = open_document(&self.document, self.histogram.as_ref(), self.labels.clone());
        self.histogram = open.as_ref().map(|o| o.histogram.clone());
        let history = self.document.history();
        let past = |back| self.document.state()?.past.next(None, back).map(str::to_owned);
        let snapshot = Snapshot {
            serial: self.serial,
            open,
            undo: history.undo_names().map(str::to_owned).collect(),
            redo: history.redo_names().map(str::to_owned).collect(),
            project: self.document.project_dir().map(Into::into),
            unsaved: self.document.is_unsaved(),
            gpu: self.gpu.clone(),
            moving: self.moving,
            selected: self.document.state().is_some_and(|s| s.subjects().any(|volume| !volume.selection.is_blank())),
            back: past(true),
            forward: past(false),
        };
        self.told = Some(now);
        self.report(Report::Snapshot(Arc::new(snapshot)));
    }

    fn report(&self, report: Report) {
        let changes_layout = !matches!(report, Report::Picture(_) | Report::Probe(_));
        // Nobody there: the next look at the requests ends the thread.
        let _gone = self.worker_end.reports.send(report);
        // What changes no layout is all there after one frame; egui makes two of a request without delay.
        self.wake.request_repaint_after(if changes_layout { Duration::ZERO } else { SOON });
    }
}
