//! Icons drawn as strokes on a 16 px grid, so that they are crisp at every scale and of one hand.

use crate::interact::{self, Tool};
use egui::{Color32, Painter, Pos2, Rect, Stroke, Vec2, pos2};

/// The icons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub(crate) enum Icon {
    Open,
    Save,
    Undo,
    Redo,
    /// A tool's own.
    Tool(Tool),
    Eye,
    EyeOff,
    Lock,
    Unlock,
    Pin,
    /// A ball, half of it shaded.
    Look,
    /// A cube: matter in 3D.
    Solid,
    Trash,
    Maximise,
    Four,
    Fit,
    Back,
    Forward,
    Keys,
    Close,
    Add,
    Note,
    Warning,
    Down,
    Right,
    Up,
    Folder,
    Project,
    File,
    Recent,
}

/// Draws an icon in the middle of a rectangle, 16 points wide.
pub(crate) fn paint(painter: &Painter, rect: Rect, icon: Icon, colour: Color32) {
    draw(painter, rect, icon, colour, 1.0);
}

/// The same 13 points wide, for places so narrow that icons would touch.
pub(crate) fn paint_narrow(painter: &Painter, rect: Rect, icon: Icon, colour: Color32) {
    draw(painter, rect, icon, colour, 13.0 / 16.0);
}

fn draw(painter: &Painter, rect: Rect, icon: Icon, colour: Color32, scale: f32) {
    let pen = Pen { painter, origin: rect.center() - Vec2::splat(8.0 * scale), colour, scale };
    match icon {
        Icon::Open => {
            pen.line(&[(2.0, 13.0), (2.0, 3.0), (6.5, 3.0), (8.0, 5.0), (13.0, 5.0), (13.0, 7.5)]);
            pen.closed(&[(2.0, 13.0), (4.5, 7.5), (15.0, 7.5), (12.5, 13.0)]);
        }
        Icon::Save => {
            pen.closed(&[(2.5, 2.5), (11.5, 2.5), (13.5, 4.5), (13.5, 13.5), (2.5, 13.5)]);
            pen.line(&[(5.0, 2.5), (5.0, 6.0), (10.0, 6.0), (10.0, 2.5)]);
            pen.line(&[(4.5, 13.5), (4.5, 9.5), (11.5, 9.5), (11.5, 13.5)]);
        }
        Icon::Undo => pen.turn(false),
        Icon::Redo => pen.turn(true),
        Icon::Tool(tool) => tool.icon().iter().for_each(|stroke| match *stroke {
            interact::Pen::Line(points) => pen.line(points),
            interact::Pen::Closed(points) => pen.closed(points),
            interact::Pen::Circle(centre, radius) => pen.circle(centre, radius),
            interact::Pen::Ellipse(centre, rx, ry) => pen.ellipse(centre, rx, ry),
        }),
        Icon::Eye | Icon::EyeOff => {
            let arc = |s: f32| -> Vec<(f32, f32)> {
                (0..=10)
                    .map(|i| (1.0 + 1.4 * i as f32, 8.0 - s * 4.5 * (i as f32 / 10.0 * std::f32::consts::PI).sin()))
                    .collect()
            };
            pen.line(&arc(1.0));
            pen.line(&arc(-1.0));
            pen.circle((8.0, 8.0), 2.0);
            if icon == Icon::EyeOff {
                pen.line(&[(2.5, 13.5), (13.5, 2.5)]);
            }
        }
        Icon::Lock | Icon::Unlock => {
            pen.closed(&[(3.0, 7.5), (13.0, 7.5), (13.0, 14.0), (3.0, 14.0)]);
            let right = if icon == Icon::Lock { 7.5 } else { 5.0 };
            pen.line(&[(5.0, 7.5), (5.0, 4.5), (6.3, 2.5), (9.7, 2.5), (11.0, 4.5), (11.0, right)]);
        }
        Icon::Pin => {
            pen.line(&[(5.0, 2.0), (11.0, 2.0)]);
            pen.line(&[(6.0, 2.0), (6.0, 7.0), (3.5, 9.5), (12.5, 9.5), (10.0, 7.0), (10.0, 2.0)]);
            pen.line(&[(8.0, 9.5), (8.0, 14.5)]);
        }
        Icon::Look => {
            pen.circle((8.0, 8.0), 6.0);
            pen.line(&[(8.0, 2.0), (8.0, 14.0)]);
            for (y, end) in [(4.5, 12.4), (6.8, 13.6), (9.2, 13.6), (11.5, 12.4)] {
                pen.line(&[(8.0, y), (end, y)]);
            }
        }
        Icon::Solid => {
            pen.closed(&[(8.0, 1.5), (14.0, 4.8), (14.0, 11.2), (8.0, 14.5), (2.0, 11.2), (2.0, 4.8)]);
            pen.line(&[(2.0, 4.8), (8.0, 8.0), (14.0, 4.8)]);
            pen.line(&[(8.0, 8.0), (8.0, 14.5)]);
        }
        Icon::Trash => {
            pen.line(&[(2.5, 4.0), (13.5, 4.0)]);
            pen.line(&[(6.0, 4.0), (6.0, 2.0), (10.0, 2.0), (10.0, 4.0)]);
            pen.line(&[(3.8, 4.0), (4.5, 14.0), (11.5, 14.0), (12.2, 4.0)]);
        }
        Icon::Maximise => pen.closed(&[(2.5, 3.5), (13.5, 3.5), (13.5, 12.5), (2.5, 12.5)]),
        Icon::Four => {
            pen.closed(&[(2.5, 2.5), (13.5, 2.5), (13.5, 13.5), (2.5, 13.5)]);
            pen.line(&[(8.0, 2.5), (8.0, 13.5)]);
            pen.line(&[(2.5, 8.0), (13.5, 8.0)]);
        }
        Icon::Fit => {
            for (x, y) in [(2.5, 2.5), (13.5, 2.5), (13.5, 13.5), (2.5, 13.5)] {
                let inward = |v: f32| if v < 8.0 { v + 3.5 } else { v - 3.5 };
                pen.line(&[(inward(x), y), (x, y), (x, inward(y))]);
            }
            pen.circle((8.0, 8.0), 2.2);
        }
        Icon::Back => pen.line(&[(9.5, 3.5), (5.0, 8.0), (9.5, 12.5)]),
        Icon::Forward => pen.line(&[(6.5, 3.5), (11.0, 8.0), (6.5, 12.5)]),
        Icon::Keys => {
            pen.closed(&[(1.0, 4.0), (15.0, 4.0), (15.0, 12.0), (1.0, 12.0)]);
            for x in [3.5, 6.5, 9.5, 12.5] {
                pen.line(&[(x - 0.5, 6.8), (x + 0.5, 6.8)]);
            }
            pen.line(&[(4.5, 9.5), (11.5, 9.5)]);
        }
        Icon::Close => {
            pen.line(&[(4.0, 4.0), (12.0, 12.0)]);
            pen.line(&[(12.0, 4.0), (4.0, 12.0)]);
        }
        Icon::Add => {
            pen.line(&[(8.0, 3.0), (8.0, 13.0)]);
            pen.line(&[(3.0, 8.0), (13.0, 8.0)]);
        }
        Icon::Note => {
            pen.closed(&[(1.5, 2.5), (14.5, 2.5), (14.5, 11.0), (8.0, 11.0), (5.0, 14.0), (5.0, 11.0), (1.5, 11.0)]);
            pen.line(&[(4.0, 5.5), (12.0, 5.5)]);
            pen.line(&[(4.0, 8.0), (9.5, 8.0)]);
        }
        Icon::Warning => {
            pen.closed(&[(8.0, 1.8), (15.0, 14.0), (1.0, 14.0)]);
            pen.line(&[(8.0, 6.0), (8.0, 10.0)]);
            pen.line(&[(8.0, 11.6), (8.0, 12.4)]);
        }
        Icon::Down => pen.line(&[(4.5, 6.5), (8.0, 10.0), (11.5, 6.5)]),
        Icon::Right => pen.line(&[(6.5, 4.5), (10.0, 8.0), (6.5, 11.5)]),
        Icon::Up => {
            pen.line(&[(8.0, 13.0), (8.0, 3.5)]);
            pen.line(&[(4.0, 7.5), (8.0, 3.5), (12.0, 7.5)]);
        }
        Icon::Folder => pen.folder(),
        Icon::Project => {
            pen.folder();
            pen.closed(&[(8.0, 7.0), (10.5, 9.5), (8.0, 12.0), (5.5, 9.5)]);
        }
        Icon::File => {
            pen.closed(&[(3.5, 1.5), (9.5, 1.5), (12.5, 4.5), (12.5, 14.5), (3.5, 14.5)]);
            pen.line(&[(9.5, 1.5), (9.5, 4.5), (12.5, 4.5)]);
        }
        Icon::Recent => {
            pen.circle((8.0, 8.0), 6.0);
            pen.line(&[(8.0, 4.5), (8.0, 8.0), (10.5, 9.5)]);
        }
    }
}

struct Pen<'a> {
    painter: &'a Painter,
    origin: Pos2,
    colour: Color32,
    /// Points for each of an icon's 16 units.
    scale: f32,
}

impl Pen<'_> {
    fn stroke(&self) -> Stroke {
        Stroke::new(if self.scale < 1.0 { 1.2 } else { 1.4 }, self.colour)
    }

    fn at(&self, (x, y): (f32, f32)) -> Pos2 {
        pos2(self.origin.x + x * self.scale, self.origin.y + y * self.scale)
    }

    fn line(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|p| self.at(*p)).collect();
        self.painter.add(egui::Shape::line(points, self.stroke()));
    }

    fn closed(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|p| self.at(*p)).collect();
        self.painter.add(egui::Shape::closed_line(points, self.stroke()));
    }

    fn circle(&self, centre: (f32, f32), radius: f32) {
        self.painter.circle_stroke(self.at(centre), radius * self.scale, self.stroke());
    }

    fn ellipse(&self, centre: (f32, f32), rx: f32, ry: f32) {
        let points = (0..24)
            .map(|i| (i as f32 / 24.0 * std::f32::consts::TAU).sin_cos())
            .map(|(s, c)| self.at((centre.0 + rx * c, centre.1 + ry * s)))
            .collect();
        self.painter.add(egui::Shape::closed_line(points, Stroke::new(1.1, self.colour)));
    }

    fn folder(&self) {
        self.closed(&[(1.5, 13.5), (1.5, 3.0), (6.0, 3.0), (7.5, 5.0), (14.5, 5.0), (14.5, 13.5)]);
    }

    /// The arrow of undo, or of redo mirrored.
    fn turn(&self, mirrored: bool) {
        let x = |x: f32| if mirrored { 16.0 - x } else { x };
        self.line(&[(x(6.0), 2.5), (x(2.5), 6.0), (x(6.0), 9.5)]);
        let arc: Vec<_> = (0..=10)
            .map(|i| (-std::f32::consts::FRAC_PI_2 + i as f32 / 10.0 * std::f32::consts::PI).sin_cos())
            .map(|(s, c)| (x(9.5 + 3.8 * c), 9.8 + 3.8 * s))
            .collect();
        self.line(&[(x(2.5), 6.0), (x(9.5), 6.0)]);
        self.line(&arc);
        self.line(&[(x(9.5), 13.6), (x(6.5), 13.6)]);
    }
}
