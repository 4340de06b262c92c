//! The window's state, and how commands leave it and reports reach it.

use crate::document::answers_ask::VoxelSaid;
use crate::document::{Command, Scene, ViewCommand, ViewName};
use crate::explode::PartId;
use crate::interact::{Button, Context, Event, Hit, Interaction, Writing};
use crate::math::DVec2;
use crate::ui::browse::names::shown;
use crate::ui::state::borders::Borders;
use crate::ui::state::dialog::Dialog;
use crate::ui::state::dialog::{Chosen, Parked};
use crate::ui::state::hit_buffer::Pictures;
use crate::ui::state::labels_shown::LabelsShown;
use crate::ui::state::layout::Layout;
use crate::ui::state::lesson::Lesson;
use crate::ui::state::message::{Message, Toast};
use crate::ui::state::note::Note;
use crate::ui::state::path_purpose::Export;
use crate::ui::state::picture_wish::Wish;
use crate::ui::state::recent::Recent;
use crate::ui::state::remarks::Remarks;
use crate::ui::state::saving::AfterSave;
use crate::ui::state::trail::Trail;
use crate::ui::state::transfer_editor::TransferEditor;
use crate::ui::state::viewports::Viewports;
use crate::ui::style::theme;
use crate::ui::thread::prediction::predict;
use crate::ui::thread::session::{OpenDocument, Request, Session, Severity, Snapshot};
use crate::ui::window::canvas::{BackdropList, Canvas};
use crate::volume::FieldKind;
use egui::{Id, Ui};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// How many voxels a piece must have to be kept until something else is said: what has fewer is a speck in most scans.
const LEAST_PIECE: u64 = 20;

/// The window: all that it holds between frames, and the line to the document.
pub struct App {
    pub(crate) session: Session,
    pub(crate) snapshot: Arc<Snapshot>,
    /// The snapshot's scene and what was sent since.
    pub(crate) scene: Option<Scene>,
    pub(crate) interaction: Interaction,
    pub(crate) viewports: Viewports,
    pub(crate) pictures: Pictures,
    pub(crate) backdrop: BackdropList,
    /// How the window is divided; changed by borders and headings alone.
    pub(crate) layout: Layout,
    pub(crate) borders: Borders,
    pub(crate) messages: Vec<Message>,
    pub(crate) messages_open: bool,
    pub(crate) toasts: Vec<Toast>,
    pub(crate) keys_open: bool,
    pub(crate) dialog: Option<Dialog>,
    /// The browser of a path that is being tried.
    pub(crate) parked: Option<Parked>,
    /// Whether the system shows file dialogs; without them the browser does.
    pub(crate) system_dialogs: bool,
    /// How many files were glanced at.
    pub(crate) glances: u64,
    /// How the last picture was wished.
    pub(crate) picture_wish: Wish,
    /// What was exported last.
    pub(crate) export_wish: Export,
    /// The first steps on the sample.
    pub(crate) lesson: Option<Lesson>,
    pub(crate) recent: Recent,
    /// Somebody has looked which of them are still there.
    pub(crate) recent_looked: bool,
    pub(crate) home: Option<PathBuf>,
    /// To be woken by other threads.
    pub(crate) context: egui::Context,
    pub(crate) busy: Option<Busy>,
    /// Since when the document has not caught up (seconds of egui's clock).
    pub(crate) behind_since: Option<f64>,
    /// The voxel under the pointer, as the document answered last.
    pub(crate) probe: Option<VoxelSaid>,
    /// Whether what is under a resting pointer may be another value now.
    pub(crate) probe_again: bool,
    /// The 3D stroke that no picture shows yet.
    pub(crate) trail: Trail,
    pub(crate) note: Option<Note>,
    /// Whether the 3D view is to be drawn anew, or finer.
    pub(crate) refining: bool,
    /// Since when, with no hand on anything.
    pub(crate) refining_since: Option<f64>,
    /// When the wheel turned a view last; its turns until it rests are one change.
    pub(crate) wheeled: Option<f64>,
    pub(crate) transfer: TransferEditor,
    /// The part whose row in the list is under the pointer.
    pub(crate) pointed_part: Option<PartId>,
    /// What is written on surfaces: what is picked, and what new things will be.
    pub(crate) writing: Writing,
    /// What was said of how things lie on surfaces.
    pub(crate) remarks: Remarks,
    /// Labels over the 3D view.
    pub(crate) labels: LabelsShown,
    /// What a control asks for that takes its time: sent when the one before is done.
    pub(crate) waiting: Option<Command>,
    pub(crate) last_paint: BTreeMap<&'static str, crate::paint::Target>,
    /// Places for a plane to mirror across, until there are three.
    pub(crate) mirror_points: Vec<crate::math::DVec3>,
    /// Of how many voxels a piece must be to be kept.
    pub(crate) least_piece: u64,
    /// The control whose drag is one step of history.
    pub(crate) group: Option<Id>,
    pub(crate) chosen: (Sender<Chosen>, Receiver<Chosen>),
    /// What came from there and waits until a question is answered.
    pub(crate) later: Vec<Chosen>,
    /// What a save was asked for on the way to; forgotten when a save is asked for its own sake.
    pub(crate) after_save: Option<AfterSave>,
    pub(crate) closing: bool,
    /// Events that wait for the next frame.
    pub(crate) held_back: Vec<egui::Event>,
    title: String,
    /// The zoom that the window's size asked for; 0 before the first pass.
    zoom: f32,
}

/// What takes its time.
#[derive(Clone, Debug)]
pub(crate) struct Busy {
    pub(crate) what: String,
    /// Seconds of egui's clock.
    pub(crate) since: f64,
    /// Done; `None` if that is not known.
    pub(crate) percent: Option<u32>,
    /// Whether it was asked to stop.
    pub(crate) stopping: bool,
}

impl App {
    /// A window on a session.
    pub fn new(session: Session) -> Self {
        Self {
            session,
            snapshot: Arc::default(),
            scene: None,
            interaction: Interaction::default(),
            viewports: Viewports::default(),
            pictures: Pictures::default(),
            backdrop: BackdropList::default(),
            layout: Layout::default(),
            borders: Borders::default(),
            messages: Vec::new(),
            messages_open: false,
            toasts: Vec::new(),
            keys_open: false,
            dialog: None,
            parked: None,
            system_dialogs: false,
            glances: 0,
            picture_wish: Wish::default(),
            export_wish: Export::of(FieldKind::Labels),
            lesson: None,
            recent: Recent::default(),
            recent_looked: false,
            home: None,
            context: egui::Context::default(),
            busy: None,
            behind_since: None,
            probe: None,
            probe_again: false,
            trail: Trail::default(),
            note: None,
            refining: false,
            refining_since: None,
            wheeled: None,
            transfer: TransferEditor::default(),
            pointed_part: None,
            writing: Writing::default(),
            remarks: Remarks::default(),
            labels: LabelsShown::default(),
            waiting: None,
            last_paint: BTreeMap::new(),
            mirror_points: Vec::new(),
            least_piece: LEAST_PIECE,
            group: None,
            chosen: channel(),
            later: Vec::new(),
            after_save: None,
            closing: false,
            held_back: Vec::new(),
            title: String::new(),
            zoom: 0.0,
        }
    }

    /// The same with something to draw pictures on; without it the window has controls only.
    pub fn with_canvas(self, canvas: Canvas) -> Self {
        Self { backdrop: BackdropList::on(canvas), ..self }
    }

    /// The same with the layout that a file keeps, and keeps it there.
    pub fn with_layout(self, kept_in: PathBuf) -> Self {
        Self { layout: Layout::read(&kept_in), borders: Borders::kept_in(kept_in), ..self }
    }

    /// The same with a list of what was open lately, and the user's home folder.
    pub fn with_files(self, recent: Recent, home: Option<PathBuf>) -> Self {
        Self { recent, home, ..self }
    }

    /// The open volume, if any.
    pub(crate) fn opened(&self) -> Option<&OpenDocument> {
        self.snapshot.open.as_ref()
    }

    /// Whether there is a document, if only one whose volumes were all taken away.
    pub(crate) fn has_document(&self) -> bool {
        let Snapshot { open, project, undo, redo, unsaved, .. } = &*self.snapshot;
        open.is_some() || project.is_some() || *unsaved || !undo.is_empty() || !redo.is_empty()
    }

    /// What the 3D view shows at a pixel, in a picture of this size.
    pub(crate) fn hit(&self, px: DVec2, size: [u32; 2]) -> Option<Hit> {
        let (scene, open) = (self.scene.as_ref()?, self.opened()?);
        self.pictures.hit(px, size, (&scene.explosion, &open.poses))
    }

    /// Sends a command and lets the window's copy follow.
    pub(crate) fn send(&mut self, command: Command) {
        self.expect(&command);
        self.request(Request::Apply(command));
    }

    /// Lets the window's copy follow a command.
    pub(crate) fn expect(&mut self, command: &Command) {
        if let (Some(scene), Some(open)) = (&mut self.scene, &self.snapshot.open) {
            predict(scene, command, &open.ground());
        }
    }

    pub(crate) fn request(&mut self, request: Request) {
        if !self.session.send(request) && !self.closing {
            self.closing = true;
            self.say(Severity::Error, "The part of the program that keeps the volume has stopped. The journal on disk holds your work up to now: close the window and open the project again.".into());
        }
    }

    /// Gives a tool what the hand did.
    pub(crate) fn interact(&mut self, event: Event) {
        let (Some(scene), Some(open)) = (&self.scene, &self.snapshot.open) else { return };
        let was = self.interaction.gesture().is_some();
        let grid = open.grid;
        let context = Context {
            scene,
            poses: &open.poses,
            grid: &grid,
            boxes: &open.boxes,
            sample_bytes: &open.sample_bytes,
            writing: &self.writing,
            voxel_mm: grid.voxel_mm(),
        };
        // A press beside all of them begins a new one, and one into the air turns the view.
        let picks = match event {
            Event::Press(Button::Primary, e) if !e.modifiers.pans() || e.modifiers.shift => {
                self.interaction.tool().picks().map(|of| self.writing.under(&e, &scene.views.camera, of))
            }
            _ => None,
        };
        let commands = self.interaction.handle(event, &context);
        if let Some(Some((one, _))) = picks {
            self.writing.picked = Some(one);
        }
        let is = self.interaction.gesture().is_some();
        if is && !was {
            // What a control or the wheel had begun ends here: a gesture is a change of its own.
            self.end_wheel();
            self.end_group();
            let view = self.viewports.captured.map_or(self.viewports.last_used, |(_, view)| view);
            self.request(Request::Held(Some(view)));
        }
        let at = match event {
            Event::Press(_, e) | Event::Move(e) | Event::Release(_, e) if e.view == ViewName::ThreeD => Some(e),
            _ => None,
        };
        for command in commands {
            let stroke = match &command {
                Command::Stroke(stroke) => Some(stroke.clone()),
                _ => None,
            };
            self.send(command);
            if let Some(stroke) = stroke {
                self.follow_stroke(&stroke, at);
            }
        }
        if was && !is {
            self.request(Request::Held(None));
        }
    }

    /// Asks what takes its time to stop.
    pub(crate) fn stop(&mut self) {
        self.wait_no_more();
        self.parked = None;
        if let Some(busy) = &mut self.busy {
            busy.stopping = true;
            self.session.stop();
        }
    }

    fn show_title(&mut self, ctx: &egui::Context) {
        let title = format!("{} – Burin", self.document_title());
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// The document's name, with a star while there is something to lose.
    pub(crate) fn document_title(&self) -> String {
        let path = match (self.opened(), &self.snapshot.project) {
            (Some(open), _) => self.snapshot.place(open),
            (None, Some(project)) => project,
            (None, None) if self.has_document() => Path::new("No volume"),
            (None, None) => return "Nothing open".into(),
        };
        let name = shown(path.file_name().unwrap_or(path.as_os_str()));
        if self.snapshot.unsaved { format!("{name}*") } else { name }
    }

    /// Puts the theme on, and larger text where the window becomes large; what the user zooms by hand stays until then.
    fn scale(&mut self, ctx: &egui::Context) {
        if self.zoom == 0.0 {
            theme::apply(ctx);
            self.fold_as_kept(ctx);
        }
        let native = ctx.native_pixels_per_point().unwrap_or(1.0);
        let zoom = theme::zoom_for(ctx.viewport_rect().height() * ctx.pixels_per_point(), native);
        if zoom != self.zoom {
            self.zoom = zoom;
            ctx.set_zoom_factor(zoom);
        }
    }

    /// One pass over the window.
    pub fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.context = ctx.clone();
        self.scale(&ctx);
        self.rest_wheel(&ctx);
        self.take_reports(&ctx);
        self.pointed_part = None;
        self.take_files(&ctx);
        self.guard_close(&ctx);
        self.take_keys(&ctx);
        self.backdrop.begin(ui);
        self.top_bar(ui);
        self.status_bar(ui);
        self.lesson_strip(ui);
        self.message_list(ui);
        self.left_panel(ui);
        self.right_panel(ui);
        self.central(ui);
        self.drag_borders(ui);
        self.keep_folds(&ctx);
        self.key_page(&ctx);
        self.show_note(&ctx);
        self.dialogs(&ctx);
        self.drop_hint(&ctx);
        if let Err(error) = self.backdrop.end(ui) {
            self.say(Severity::Error, error.to_string());
        }
        self.rest_control(&ctx);
        // A window that loses the focus never hears the button go up.
        let left = ctx.input(|i| i.events.contains(&egui::Event::WindowFocused(false)));
        if left && self.viewports.captured.take().is_some() {
            self.viewports.pen = None;
            self.interact(Event::Abort);
        }
        self.show_title(&ctx);
        let now = ctx.input(|i| i.time);
        let behind = self.snapshot.serial < self.session.serial();
        self.behind_since = if behind { self.behind_since.or(Some(now)) } else { None };
        if behind {
            ctx.request_repaint_after(std::time::Duration::from_millis(50));
        }
        if self.busy.is_some() {
            ctx.request_repaint_after(std::time::Duration::from_millis(100));
        }
    }

    /// Tells the session which views are on the screen.
    pub(crate) fn report_views(&mut self, shown: Vec<ViewName>, sizes: Vec<(ViewName, [u32; 2])>) {
        if self.viewports.shown != shown {
            self.viewports.shown.clone_from(&shown);
            self.request(Request::Show(shown));
        }
        for (view, size) in sizes {
            if self.viewports.sizes.insert(view, size) != Some(size) {
                self.send(Command::View(ViewCommand::Size { view, size }));
            }
        }
    }
}

impl eframe::App for App {
    fn on_exit(&mut self) {
        if self.closing || !self.snapshot.unsaved {
            self.request(Request::Quit);
        }
    }

    fn raw_input_hook(&mut self, ctx: &egui::Context, raw: &mut egui::RawInput) {
        self.hold_back(ctx, raw);
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }
}
