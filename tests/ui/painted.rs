//! The window as it is painted: grounds, pictures and what lies over them.

use super::driver::{SMALL, Window};
use super::replies::lost;
use super::volumes::two_volumes;
use burin::document::ViewName;
use burin::math::DVec3;
use burin::ui::style::theme;
use burin::ui::{Canvas, Picture, Report};
use burin::volume::VolumeId;
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui::Color32;
use egui_kittest::kittest::Queryable;
use std::time::Duration;

/// A device as a window has it; `None` where there is none.
fn render_state() -> Option<RenderState> {
    crate::common::gpu::gpu()?;
    let setup = egui_kittest::wgpu::default_wgpu_setup();
    Some(egui_kittest::wgpu::create_render_state(setup, RendererOptions::PREDICTABLE))
}

/// A picture of one colour.
fn plain(window: &Window, view: ViewName, size: [u32; 2], rgb: [u8; 3]) -> Picture {
    let pixels = (size[0] * size[1]) as usize;
    let rgba = [rgb[0], rgb[1], rgb[2], 255].repeat(pixels);
    let camera = window.scene.views.camera;
    Picture { view, size, rgba, depth_mm: Vec::new(), object: Vec::new(), camera, serial: 0 }
}

#[test]
fn pictures_lie_under_their_marks_and_panels_on_their_ground() {
    let Some(state) = render_state() else { return };
    let canvas = Canvas::new(&state).unwrap();
    let mut window = Window::painted(SMALL, state, canvas);
    let pictures = [(ViewName::ThreeD, [60, 0, 90]), (ViewName::Axial, [90, 20, 0]), (ViewName::Sagittal, [0, 80, 40])];
    for (view, rgb) in pictures {
        let report = Report::Picture(Box::new(plain(&window, view, [30, 20], rgb)));
        window.report(report);
    }
    let image = window.harness.render().unwrap();
    let at = |x: f32, y: f32| {
        let [r, g, b, _] = image.get_pixel(x as u32, y as u32).0;
        Color32::from_rgb(r, g, b)
    };
    for ((_, [r, g, b]), name) in pictures.into_iter().zip(["3D view", "Axial view", "Sagittal view"]) {
        let rect = window.harness.get_by_label(name).rect();
        // Where no letter, line or bar is.
        for (u, v) in [(0.02, 0.02), (0.3, 0.3), (0.7, 0.8), (0.98, 0.02)] {
            let (x, y) = (rect.left() + rect.width() * u, rect.top() + rect.height() * v);
            assert_eq!(at(x, y), Color32::from_rgb(r, g, b), "{name} at {u} {v}");
        }
    }
    let axial = window.harness.get_by_label("Axial view").rect();
    let column = (0..axial.width() as u32).map(|x| at(axial.left() + x as f32, axial.top() + axial.height() * 0.3));
    let crossed = column.filter(|c| *c != Color32::from_rgb(90, 20, 0)).count();
    assert!((1..=2).contains(&crossed), "the crosshair's line is {crossed} pixels wide");
    let coronal = window.harness.get_by_label("Coronal view").rect();
    assert_eq!(at(coronal.left() + 20.0, coronal.top() + 20.0), Color32::BLACK, "its picture has not come");
    // Beside and between the controls.
    for (name, ground) in [("Section Brush", theme::PANEL), ("Section Parts", theme::PANEL), ("Open", theme::BAR)] {
        let rect = window.harness.get_by_label(name).rect();
        assert_eq!(at(rect.left() - 3.0, rect.center().y), ground, "beside {name}");
    }
    let plot = window.harness.get_by_label("Transfer function over the histogram").rect();
    assert_eq!(at(plot.right() - 3.0, plot.top() + 3.0), theme::DEEP, "detail lies on its panel's ground");
}

#[test]
fn a_question_darkens_the_whole_window_and_is_not_dark_itself() {
    let Some(state) = render_state() else { return };
    let canvas = Canvas::new(&state).unwrap();
    let mut window = Window::painted(SMALL, state, canvas);
    let report = Report::Picture(Box::new(plain(&window, ViewName::ThreeD, [8, 8], [200, 100, 50])));
    window.report(report);
    let view = window.harness.get_by_label("3D view").rect();
    let lit = window.harness.render().unwrap();
    window.report(lost(&[("a", "/data/head.nii")], Duration::ZERO));
    let dark = window.harness.render().unwrap();
    let shade = 1.0 - f64::from(theme::SHADE.a()) / 255.0;
    let open = window.harness.get_by_label("Open").rect();
    for at in [view.left_top() + egui::vec2(9.0, 9.0), view.left_bottom() + egui::vec2(40.0, -60.0), open.center()] {
        let [before, after] = [&lit, &dark].map(|image| image.get_pixel(at.x as u32, at.y as u32).0);
        for (b, a) in before.iter().zip(after).take(3) {
            assert!((f64::from(*b) * shade - f64::from(a)).abs() <= 2.0, "{before:?} became {after:?} at {at:?}");
        }
    }
    let question = window.harness.get_by_label("Unsaved work was found").rect();
    let ground = dark.get_pixel(question.left() as u32 - 6, question.center().y as u32).0;
    assert!(ground[0] > 36, "{ground:?}");
}

#[test]
fn the_crosshair_lies_where_its_point_is() {
    let Some(state) = render_state() else { return };
    let canvas = Canvas::new(&state).unwrap();
    let mut window = Window::painted(SMALL, state, canvas);
    let at = window.scene.views.slices[0].centre + DVec3::new(7.0, -4.0, 0.0);
    window.scene.views.crosshair = at;
    window.snapshot(|_| {});
    let black = plain(&window, ViewName::Axial, [30, 20], [0; 3]);
    window.report(Report::Picture(Box::new(black)));
    let image = window.harness.render().unwrap();
    let body = window.harness.get_by_label("Axial view").rect();
    let px_per_mm = f64::from(body.height()) / window.scene.views.slices[0].height_mm;
    // From the feet: the patient's right, +x, lies to the left; anterior, +y, up.
    let x = f64::from(body.center().x) - 7.0 * px_per_mm;
    let y = f64::from(body.center().y) + 4.0 * px_per_mm;
    let lit = |x: f64, y: f64| image.get_pixel(x as u32, y as u32).0[..3].iter().any(|c| *c > 40);
    let near =
        |from: f64, lit: &dyn Fn(f64) -> bool| (-30..=30).map(|d| from + f64::from(d)).filter(|p| lit(*p)).collect();
    let (left, top) = (f64::from(body.left()) + 60.0, f64::from(body.top()) + 60.0);
    let columns: Vec<f64> = near(x, &|x| lit(x, top));
    let rows: Vec<f64> = near(y, &|y| lit(left, y));
    assert!(columns.len() == 1 && (columns[0] - x).abs() <= 1.0, "{columns:?} where {x} was to be");
    assert!(rows.len() == 1 && (rows[0] - y).abs() <= 1.0, "{rows:?} where {y} was to be");
    assert!(!lit(x, y), "the middle is open");
}

#[test]
fn a_view_whose_picture_was_refused_shows_its_ground() {
    let Some(state) = render_state() else { return };
    let canvas = Canvas::new(&state).unwrap();
    let mut window = Window::painted(SMALL, state, canvas);
    let good = plain(&window, ViewName::Axial, [30, 20], [90, 20, 0]);
    let short = Picture { rgba: vec![0; 8], ..plain(&window, ViewName::Axial, [30, 20], [0; 3]) };
    for (picture, ground) in [(good, Color32::from_rgb(90, 20, 0)), (short, Color32::BLACK)] {
        window.report(Report::Picture(Box::new(picture)));
        let image = window.harness.render().unwrap();
        let rect = window.harness.get_by_label("Axial view").rect();
        let [r, g, b, _] = image.get_pixel(rect.left() as u32 + 20, rect.top() as u32 + 20).0;
        assert_eq!(Color32::from_rgb(r, g, b), ground);
    }
}

/// A picture of one colour of something at one distance from the eye; `step` mm further in its right half.
fn solid(window: &Window, serial: u64, step: f32) -> Picture {
    let view = window.harness.get_by_label("3D view").rect();
    let (size, camera) = ([view.width() as u32, view.height() as u32], window.scene.views.camera);
    let pixels = (size[0] * size[1]) as usize;
    let near = camera.eye.distance(camera.target) as f32;
    let right = |i: usize| i % size[0] as usize >= size[0] as usize / 2;
    let depth_mm = (0..pixels).map(|i| if right(i) { near + step } else { near }).collect();
    Picture {
        depth_mm,
        object: vec![burin::gpu::ObjectId::new(burin::volume::VolumeId::FIRST, 0, false, 0); pixels],
        serial,
        ..plain(window, ViewName::ThreeD, size, [60, 0, 90])
    }
}

#[test]
fn a_stroke_in_3d_is_drawn_at_once_until_a_picture_shows_it_or_it_is_taken_back() {
    let Some(state) = render_state() else { return };
    let canvas = Canvas::new(&state).unwrap();
    let mut window = Window::painted(SMALL, state, canvas);
    window.scene.brush.target = burin::paint::Target::Colour([0.0, 1.0, 0.0, 1.0]);
    window.snapshot(|_| {});
    let report = Report::Picture(Box::new(solid(&window, 0, 0.0)));
    window.report(report);
    window.click("Brush");
    let view = window.harness.get_by_label("3D view").rect();
    let (from, to) = (view.center() - egui::vec2(80.0, 0.0), view.center() + egui::vec2(60.0, 0.0));
    let stroke = |window: &mut Window| {
        window.harness.drag_at(from);
        window.harness.run_steps(1);
        window.harness.hover_at(to);
        window.harness.run_steps(1);
    };
    // Where the stroke began, half way, and far from it.
    let tinted = |window: &mut Window| {
        let image = window.harness.render().unwrap();
        [from, from.lerp(to, 0.5), view.center() + egui::vec2(0.0, 100.0)].map(|at| {
            let [r, g, b, _] = image.get_pixel(at.x as u32, at.y as u32).0;
            let painted = g > 80 && g > r && g > b;
            assert!(painted || [r, g, b] == [60, 0, 90], "{r} {g} {b} at {at:?}");
            painted
        })
    };
    assert_eq!(tinted(&mut window), [false; 3]);
    stroke(&mut window);
    assert_eq!(tinted(&mut window), [true, true, false], "before any picture of it");
    window.key(egui::Modifiers::NONE, egui::Key::Escape);
    assert_eq!(tinted(&mut window), [false; 3], "taken back");
    window.harness.drop_at(to);
    window.harness.run_steps(2);
    stroke(&mut window);
    window.harness.drop_at(to);
    window.harness.run_steps(2);
    let old = Report::Picture(Box::new(solid(&window, 0, 0.0)));
    window.report(old);
    assert_eq!(tinted(&mut window), [true, true, false], "a picture of before does not show it");
    let new = Report::Picture(Box::new(solid(&window, u64::MAX, 0.0)));
    window.report(new);
    assert_eq!(tinted(&mut window), [false; 3], "the voxels follow");
    // Over a step deeper than the brush both floors are painted all along, whether the pointer was sampled there or not.
    let stepped = Report::Picture(Box::new(solid(&window, u64::MAX, 40.0)));
    window.report(stepped);
    stroke(&mut window);
    let image = window.harness.render().unwrap();
    for share in [0.0, 0.2, 0.4, 0.5, 0.65, 0.8] {
        let at = from.lerp(to, share);
        let [r, g, b, _] = image.get_pixel(at.x as u32, at.y as u32).0;
        assert!(g > 80 && g > r && g > b, "{share} of the way: {r} {g} {b}");
    }
}

#[test]
fn a_stroke_thinner_than_any_pixel_is_drawn_at_once_too() {
    let Some(state) = render_state() else { return };
    let canvas = Canvas::new(&state).unwrap();
    let mut window = Window::painted(SMALL, state, canvas);
    window.scene.brush.target = burin::paint::Target::Colour([0.0, 1.0, 0.0, 1.0]);
    window.scene.brush.radius_mm = 0.0;
    window.snapshot(|_| {});
    let report = Report::Picture(Box::new(solid(&window, 0, 0.0)));
    window.report(report);
    window.click("Brush");
    let view = window.harness.get_by_label("3D view").rect();
    let (from, to) = (view.center() - egui::vec2(80.0, 30.0), view.center() + egui::vec2(60.0, -30.0));
    window.harness.drag_at(from);
    window.harness.run_steps(1);
    window.harness.hover_at(to);
    window.harness.run_steps(1);
    let image = window.harness.render().unwrap();
    for share in [0.0, 0.2, 0.4, 0.5, 0.65, 0.8] {
        let at = from.lerp(to, share);
        let green = |dy: i32| {
            let [r, g, b, _] = image.get_pixel(at.x as u32, (at.y as i32 + dy) as u32).0;
            g > 80 && g > r && g > b
        };
        // The surface's points lie some pixels apart.
        assert!((-2..=2).any(green), "{share} of the way");
        assert!(!green(-9) && !green(9), "beside it, {share} of the way");
    }
}

#[test]
fn pictures_and_panels_stay_while_volumes_are_chosen_and_removed_and_go_with_another_document() {
    let Some(state) = render_state() else { return };
    let canvas = Canvas::new(&state).unwrap();
    let mut window = Window::painted(SMALL, state, canvas);
    two_volumes(&mut window);
    window.report(Report::Picture(Box::new(plain(&window, ViewName::ThreeD, [30, 20], [60, 0, 90]))));
    let view = window.harness.get_by_label("3D view").rect();
    let shown = |window: &mut Window| {
        let image = window.harness.render().unwrap();
        let [r, g, b, _] = image.get_pixel((view.left() + view.width() * 0.3) as u32, (view.top() + 40.0) as u32).0;
        [r, g, b]
    };
    assert_eq!(shown(&mut window), [60, 0, 90]);
    let brush = window.rect("Section Brush");
    // Every word of the document comes with a histogram of its own, as one of another volume does.
    window.scene.volumes.active = VolumeId(1);
    window.snapshot(|_| {});
    assert_eq!(shown(&mut window), [60, 0, 90], "another volume is active");
    assert_eq!(window.rect("Section Brush"), brush);
    window.scene.volumes.active = VolumeId::FIRST;
    window.scene.volumes.all.remove(&VolumeId(1));
    window.scene.shown.remove(&VolumeId(1));
    window.snapshot(|_| {});
    assert_eq!(shown(&mut window), [60, 0, 90], "the other one is removed");
    assert_eq!(window.rect("Section Brush"), brush, "nothing moves under the hand");
    window.snapshot(|s| s.open.as_mut().unwrap().opening += 1);
    assert_eq!(shown(&mut window), [0, 0, 0], "another document");
}
