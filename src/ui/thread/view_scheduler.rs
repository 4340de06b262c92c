//! Which view is to be drawn next, how finely, and whether it has to be at all.
//!
//! A picture is drawn again only if what it depends on changed. While something is held or moves the 3D view is drawn with as few
//! pixels as the eye forgives; at rest it is refined in bands of rows, so that a command never waits long for a picture.

use crate::document::effects::Redraws;
use crate::document::{Document, DocumentError, SlicePlane, ViewName};
use crate::gpu::Image;
use crate::gpu::ObjectId;
use crate::math::Camera;
use crate::ui::thread::session::Picture;
use std::collections::BTreeMap;
use std::time::Instant;

/// Milliseconds that a picture in motion should take.
const MOVING_MS: f64 = 60.0;
/// Milliseconds that a band of a refined picture should take.
const BAND_MS: f64 = 40.0;
/// Coarsest picture in motion: one pixel for this many either way.
const COARSEST: f64 = 4.0;

/// What a picture depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Basis {
    /// Changes of what is drawn in the view, counted.
    changes: u64,
    size: [u32; 2],
    plane: Option<SlicePlane>,
    camera: Camera,
}

#[derive(Debug)]
struct DrawnView {
    basis: Basis,
    /// All pixels are there.
    fine: bool,
    /// When, counted in pictures.
    turn: u64,
}

/// A fine picture on its way.
#[derive(Debug)]
struct Refining {
    basis: Basis,
    rows: u32,
    rgba: Vec<u8>,
    depth_mm: Vec<f32>,
    object: Vec<ObjectId>,
}

/// Which pictures were drawn of what, and how long a pixel takes.
#[derive(Debug)]
pub(crate) struct ViewScheduler {
    /// Changes of what the 3D view draws, and of what slices draw.
    three_d: u64,
    slices: u64,
    turn: u64,
    drawn: BTreeMap<ViewName, DrawnView>,
    refining: Option<Refining>,
    /// Of the 3D view, lately.
    micros_per_pixel: f64,
}

impl Default for ViewScheduler {
    fn default() -> Self {
        Self { three_d: 0, slices: 0, turn: 0, drawn: BTreeMap::new(), refining: None, micros_per_pixel: 0.5 }
    }
}

impl ViewScheduler {
    /// Takes in which pictures a command that is about to be done may change.
    pub(crate) fn note(&mut self, redraws: Redraws) {
        self.three_d += u64::from(redraws.three_d);
        self.slices += u64::from(redraws.slices);
    }

    fn basis(&self, document: &Document, view: ViewName) -> Option<Basis> {
        let state = document.state()?;
        let views = &state.scene.views;
        let plane = SlicePlane::new(state.at(None).ok()?.grid(), views, view);
        let size = views.slice(view).map_or(views.size, |s| s.size);
        let changes = if view == ViewName::ThreeD { self.three_d } else { self.slices };
        Some(Basis { changes, size, plane, camera: views.camera })
    }

    /// The view that needs drawing most: of those that show something old every second time the one under the hand, else the one
    /// that waited longest, so that none starves while a stroke or a motion changes them all the time; then the coarse.
    fn next(
        &self,
        document: &Document,
        shown: &[ViewName],
        hand: Option<ViewName>,
        rough: bool,
    ) -> Option<(ViewName, Basis)> {
        let all = || shown.iter().filter_map(|&view| Some((view, self.basis(document, view)?)));
        let stale = all().filter(|(view, basis)| !self.drawn.get(view).is_some_and(|d| same(&d.basis, basis, *view)));
        let waited = |view: &ViewName| self.drawn.get(view).map_or(0, |d| d.turn);
        let in_hand = |view: ViewName| hand == Some(view) && waited(&view) < self.turn;
        // Slices are quick: of those that never were drawn they come first.
        let stale = stale.min_by_key(|(view, _)| (!in_hand(*view), waited(view), *view == ViewName::ThreeD));
        let coarse = || all().find(|(view, _)| !rough && self.drawn.get(view).is_some_and(|d| !d.fine));
        stale.or_else(coarse)
    }

    /// Whether the 3D view, if it is on the screen, shows something old or coarse.
    pub(crate) fn is_refining(&self, document: &Document, shown: &[ViewName]) -> bool {
        let view = ViewName::ThreeD;
        let Some(basis) = self.basis(document, view).filter(|_| shown.contains(&view)) else { return false };
        self.drawn.get(&view).is_none_or(|d| !d.fine || !same(&d.basis, &basis, view))
    }

    /// Whether a view waits to be drawn.
    pub(crate) fn has_work(&self, document: &Document, shown: &[ViewName], rough: bool) -> bool {
        self.next(document, shown, None, rough).is_some()
    }

    /// Draws one view, or a band of one. `hand`: the view that something is held in. `rough`: something is held or moves.
    ///
    /// # Errors
    /// As `Document::picture`; the view is not tried again until it changes.
    pub(crate) fn draw(
        &mut self,
        document: &mut Document,
        shown: &[ViewName],
        hand: Option<ViewName>,
        rough: bool,
    ) -> Result<Option<Picture>, DocumentError> {
        let Some((view, basis)) = self.next(document, shown, hand, rough) else { return Ok(None) };
        self.turn += 1;
        let drawn = if view == ViewName::ThreeD {
            let known = self.drawn.get(&view).is_some_and(|d| same(&d.basis, &basis, view));
            if known { self.refine(document, basis) } else { self.preview(document, basis) }
        } else {
            let image = document.picture(view, basis.size, None);
            self.drawn.insert(view, DrawnView { basis, fine: true, turn: self.turn });
            image.map(|image| Some(picture(view, basis.camera, &image, [0.0; 3])))
        };
        if drawn.is_err() {
            self.refining = None;
            self.drawn.insert(view, DrawnView { basis, fine: true, turn: self.turn });
        }
        drawn
    }

    fn preview(&mut self, document: &mut Document, basis: Basis) -> Result<Option<Picture>, DocumentError> {
        self.refining = None;
        let pixels = f64::from(basis.size[0]) * f64::from(basis.size[1]);
        let divisor = (pixels * self.micros_per_pixel / 1000.0 / MOVING_MS).sqrt();
        // Half the pixels either way, or fewer; all of them only if they are nearly free.
        let divisor = if divisor < 0.5 { 1.0 } else { ((divisor * 2.0).round() * 0.5).clamp(2.0, COARSEST) };
        let size = basis.size.map(|s| ((f64::from(s) / divisor).round() as u32).max(1));
        let begun = Instant::now();
        let image = document.picture(ViewName::ThreeD, size, None)?;
        self.learn(begun, size);
        self.drawn.insert(
            ViewName::ThreeD,
            DrawnView { basis, fine: size == basis.size && !document.is_pending(), turn: self.turn },
        );
        Ok(Some(picture(ViewName::ThreeD, basis.camera, &image, background(document))))
    }

    fn refine(&mut self, document: &mut Document, basis: Basis) -> Result<Option<Picture>, DocumentError> {
        let mut now = match self.refining.take().filter(|r| same(&r.basis, &basis, ViewName::ThreeD)) {
            Some(now) => now,
            None => Refining { basis, rows: 0, rgba: Vec::new(), depth_mm: Vec::new(), object: Vec::new() },
        };
        let [width, height] = basis.size;
        let rows = (BAND_MS * 1000.0 / (self.micros_per_pixel * f64::from(width)).max(1e-3)) as u32;
        // Bands that begin on a tile share no tile.
        let end = (now.rows + (rows / 8 * 8).max(16)).min(height);
        let begun = Instant::now();
        let image = document.picture_rows(basis.size, now.rows..end)?;
        self.learn(begun, [width, end - now.rows]);
        now.rgba.extend(image.to_rgba8(Some(background(document))));
        now.depth_mm.extend(image.depth_mm);
        now.object.extend(image.object);
        now.rows = end;
        if end < height {
            self.refining = Some(now);
            return Ok(None);
        }
        self.drawn.insert(ViewName::ThreeD, DrawnView { basis, fine: true, turn: self.turn });
        let Refining { rgba, depth_mm, object, .. } = now;
        let camera = basis.camera;
        Ok(Some(Picture { view: ViewName::ThreeD, size: basis.size, rgba, depth_mm, object, camera, serial: 0 }))
    }

    fn learn(&mut self, begun: Instant, size: [u32; 2]) {
        let micros = begun.elapsed().as_secs_f64() * 1e6 / (f64::from(size[0]) * f64::from(size[1])).max(1.0);
        self.micros_per_pixel = self.micros_per_pixel * 0.5 + micros * 0.5;
    }
}

/// Whether two pictures would be equal: a slice does not depend on the camera, the 3D view not on the planes.
fn same(a: &Basis, b: &Basis, view: ViewName) -> bool {
    let place = match view {
        ViewName::ThreeD => a.camera == b.camera,
        _ => a.plane == b.plane,
    };
    a.changes == b.changes && a.size == b.size && place
}

fn background(document: &Document) -> [f32; 3] {
    document.state().map_or([0.0; 3], |s| s.scene.look.background)
}

fn picture(view: ViewName, camera: Camera, image: &Image, background: [f32; 3]) -> Picture {
    let solid = view == ViewName::ThreeD;
    Picture {
        view,
        size: image.size,
        rgba: image.to_rgba8(Some(background)),
        depth_mm: if solid { image.depth_mm.clone() } else { Vec::new() },
        object: if solid { image.object.clone() } else { Vec::new() },
        camera,
        serial: 0,
    }
}
