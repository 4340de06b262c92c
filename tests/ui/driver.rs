//! A window driven by accessible names; the other end of its session is the test.

use super::scene;
use crate::common::one::segments;
use burin::document::{Command, Scene, ViewCommand};
use burin::explode::{Explosion, PartId};
use burin::math::{DVec3, Plane};
use burin::ui::{App, Canvas, OpenDocument, Recent, Report, Request, Session, Snapshot, WorkerEnd};
use burin::volume::{Histogram, Statistics, VoxelType};
use eframe::egui_wgpu::RenderState;
use egui::{Modifiers, vec2};
use egui_kittest::{Harness, kittest::Queryable, wgpu::WgpuTestRenderer};
use std::path::PathBuf;
use std::sync::Arc;

/// The window and the other end of its session.
pub struct Window {
    pub harness: Harness<'static, App>,
    pub worker_end: WorkerEnd,
    pub scene: Scene,
    serial: u64,
}

/// The volume in two parts.
fn halves(explosion: &mut Explosion) {
    let centre = explosion.parts[0].centre();
    // No border of parts runs through the slice that the crosshair is looked at in.
    let plane = Plane::through(centre, DVec3::Z).unwrap();
    explosion.split_at_rest(PartId(1), &plane).unwrap();
    for (part, (id, name)) in explosion.parts.iter_mut().zip([(1, "Lower half"), (2, "Upper half")]) {
        (part.id, part.name) = (PartId(id), name.into());
    }
}

impl Window {
    /// With nothing open.
    pub fn empty(size: [f32; 2]) -> Self {
        Self::made(size, |app| app)
    }

    /// As [`open`](Self::open), with a layout that is kept in a file.
    pub fn keeping(size: [f32; 2], layout: &std::path::Path) -> Self {
        Self::made(size, |app| app.with_layout(layout.into())).with_volume()
    }

    /// With nothing open, a list of what was open lately and a home folder.
    pub fn with_files(size: [f32; 2], recent: Recent, home: Option<PathBuf>) -> Self {
        Self::made(size, |app| app.with_files(recent, home))
    }

    fn made(size: [f32; 2], with: impl FnOnce(App) -> App) -> Self {
        let (session, worker_end) = Session::pair();
        let app = with(App::new(session));
        let harness =
            Harness::builder().with_size(vec2(size[0], size[1])).build_ui_state(|ui, app: &mut App| app.show(ui), app);
        Self { harness, worker_end, scene: scene().1, serial: 0 }
    }

    /// As [`open`](Self::open), on a device that paints it.
    pub fn painted(size: [f32; 2], state: RenderState, canvas: Canvas) -> Self {
        let (session, worker_end) = Session::pair();
        let app = App::new(session).with_canvas(canvas);
        let harness = Harness::builder()
            .with_size(vec2(size[0], size[1]))
            .renderer(WgpuTestRenderer::from_render_state(state))
            .build_ui_state(|ui, app: &mut App| app.show(ui), app);
        Self { harness, worker_end, scene: scene().1, serial: 0 }.with_volume()
    }

    /// A window with a volume, two segments, two parts and some steps.
    pub fn open(size: [f32; 2]) -> Self {
        Self::empty(size).with_volume()
    }

    fn with_volume(mut self) -> Self {
        let s = &mut self.scene;
        for id in [1, 2] {
            segments(s).ensure(id);
        }
        halves(&mut s.explosion);
        self.snapshot(|_| {});
        self
    }

    /// The document says what it is now; what the window answers is thrown away.
    pub fn snapshot(&mut self, change: impl FnOnce(&mut Snapshot)) {
        self.tell(change);
        self.sent();
    }

    /// The document says what it is now.
    pub fn tell(&mut self, change: impl FnOnce(&mut Snapshot)) {
        let (grid, _) = scene();
        let histogram =
            Histogram { min: 0.0, max: 100.0, bins: (0..50).map(|i| 1000 / (i + 1)).collect(), ..Histogram::default() };
        let opened = OpenDocument {
            opening: 1,
            scene: Arc::new(self.scene.clone()),
            poses: Arc::default(),
            grid,
            centres: self.scene.volumes.all.keys().map(|&id| (id, grid.world_bounds().centre())).collect(),
            boxes: Default::default(),
            written: Default::default(),
            labels: Default::default(),
            sample_bytes: self.scene.volumes.all.keys().map(|&id| (id, 9)).collect(),
            voxel_type: VoxelType::U8,
            statistics: Statistics { min: 0.0, max: 100.0, sum: 1e6, nan_count: 0, ..Statistics::default() },
            histogram: Arc::new(histogram),
        };
        let mut snapshot = Snapshot {
            serial: u64::MAX,
            open: Some(opened),
            undo: ["Stroke", "Axis split", "Rename part"].map(String::from).to_vec(),
            redo: vec!["Degree of explosion".into()],
            gpu: Some(Ok("llvmpipe (LLVM 15)".into())),
            selected: true,
            ..Snapshot::default()
        };
        change(&mut snapshot);
        self.worker_end.reports.send(Report::Snapshot(Arc::new(snapshot))).unwrap();
        self.harness.run_steps(3);
    }

    /// Something comes from the document; what the window answers is thrown away.
    pub fn report(&mut self, report: Report) {
        self.worker_end.reports.send(report).unwrap();
        self.harness.run_steps(3);
        self.sent();
    }

    /// What the window asked for since the last time, without the sizes that it reports of itself.
    pub fn sent(&mut self) -> Vec<Command> {
        self.worker_end
            .requests
            .try_iter()
            .filter_map(|(serial, request)| {
                assert!(serial >= self.serial, "requests keep their order");
                self.serial = serial;
                match request {
                    Request::Apply(Command::View(ViewCommand::Size { .. })) => None,
                    Request::Apply(command) => Some(command),
                    _ => None,
                }
            })
            .collect()
    }

    pub fn click(&mut self, name: &str) -> Vec<Command> {
        self.harness.get_by_label(name).click();
        self.harness.run_steps(3);
        self.sent()
    }

    /// Where a control lies.
    pub fn rect(&self, name: &str) -> egui::Rect {
        self.harness.get_by_label(name).rect()
    }

    /// Drags from the middle of a control.
    pub fn drag(&mut self, name: &str, by: egui::Vec2) -> Vec<Command> {
        let from = self.rect(name).center();
        self.harness.hover_at(from);
        self.harness.run_steps(1);
        self.harness.drag_at(from);
        self.harness.run_steps(1);
        for share in [0.25, 0.6, 1.0] {
            self.harness.hover_at(from + by * share);
            self.harness.run_steps(1);
        }
        self.harness.drop_at(from + by);
        self.harness.run_steps(3);
        self.sent()
    }

    pub fn key(&mut self, modifiers: Modifiers, key: egui::Key) -> Vec<Command> {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
        self.sent()
    }
}

pub const SMALLEST: [f32; 2] = [900.0, 600.0];
pub const SMALL: [f32; 2] = [1280.0, 800.0];
pub const LARGE: [f32; 2] = [2560.0, 1440.0];
