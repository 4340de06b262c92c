//! Distance fields, levels, figures and patterns against closed forms and brute force.

use burin::annotate::picture::boundary::boundary;
use burin::annotate::picture::distance::{DistanceField, MAX_SIDE};
use burin::annotate::picture::fonts::{FontBytes, Fonts};
use burin::annotate::picture::hatch::{Figure, Hatch};
use burin::annotate::picture::outline::{Outline, Rect, flatten_cubic, flatten_quadratic};
use burin::annotate::picture::shapes::{Arrow, Frame, Ruler, ScaleBar, length_in_words};
use burin::annotate::picture::sheet::{Paint, Sheet};
use burin::annotate::picture::texture::{Level, TexelFormat, Texture};
use glam::{DAffine2, DVec2};
use half::f16;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::borrow::Cow;

const PLAIN: Paint = Paint { fill: [0, 0, 0, 255], halo: None };

fn shipped() -> Fonts {
    let bytes = Cow::Borrowed(include_bytes!("../../assets/fonts/DejaVuSans.ttf").as_slice());
    Fonts::new(vec![FontBytes { name: "DejaVu Sans".into(), bytes, index: 0 }]).unwrap()
}

fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Rect {
    Rect::new(DVec2::new(x0, y0), DVec2::new(x1, y1))
}

/// Texels of a field with their centres' places, mm.
fn texels(field: &DistanceField, corner: DVec2) -> impl Iterator<Item = (DVec2, f64)> {
    let (width, texel) = (field.width, field.texel_mm);
    field.texels.iter().enumerate().map(move |(i, &d)| {
        let (x, y) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        (corner + DVec2::new(x, -y) * texel, f64::from(d))
    })
}

fn to_square(p: DVec2, half: DVec2) -> f64 {
    // Inigo Quilez's box, turned inside positive.
    let q = p.abs() - half;
    -(q.max(DVec2::ZERO).length() + q.max_element().min(0.0))
}

#[test]
fn a_disc_and_a_rectangle_have_the_distances_of_their_equations() {
    let mut disc = Outline::new();
    let centre = DVec2::new(0.37, -0.21);
    disc.add_disc(centre, 5.0, 720);
    let corner = DVec2::new(-8.0, 8.0);
    let field = DistanceField::of(&disc, corner, 0.125, [128, 128], 12.0).unwrap();
    for (p, d) in texels(&field, corner) {
        let want = ((5.0 - p.distance(centre)) / 0.125).clamp(-12.0, 12.0);
        assert!((d - want).abs() < 2e-3, "{p}: {d} for {want}");
    }
    let mut square = Outline::new();
    square.add_rect(rect(-5.0, -2.0, 5.0, 2.0));
    let field = DistanceField::of(&square, corner, 0.125, [128, 128], 20.0).unwrap();
    for (p, d) in texels(&field, corner) {
        let want = (to_square(p, DVec2::new(5.0, 2.0)) / 0.125).clamp(-20.0, 20.0);
        assert!((d - want).abs() < 1e-5, "{p}: {d} for {want}");
    }
}

#[test]
fn overlapping_figures_have_no_seam() {
    // Two halves that share a strip, two that share only a side, and one within another: the whole is a rectangle of 10 × 4.
    for parts in [
        [rect(-5.0, -2.0, 1.0, 2.0), rect(-1.0, -2.0, 5.0, 2.0)],
        [rect(-5.0, -2.0, 0.3, 2.0), rect(0.3, -2.0, 5.0, 2.0)],
        [rect(-5.0, -2.0, 5.0, 2.0), rect(-1.0, -1.0, 1.0, 2.0)],
    ] {
        let mut outline = Outline::new();
        parts.into_iter().for_each(|r| outline.add_rect(r));
        let corner = DVec2::new(-6.0, 4.0);
        let field = DistanceField::of(&outline, corner, 0.1, [120, 80], 25.0).unwrap();
        for (p, d) in texels(&field, corner) {
            let want = (to_square(p, DVec2::new(5.0, 2.0)) / 0.1).clamp(-25.0, 25.0);
            assert!((d - want).abs() < 1e-4, "{parts:?} {p}: {d} for {want}");
        }
    }
    // Sides that run along each other in part: the upper left corner is open, the way between both is not.
    let mut stairs = Outline::new();
    [rect(-5.0, -2.0, 0.0, 1.0), rect(0.0, -1.0, 5.0, 3.0)].into_iter().for_each(|r| stairs.add_rect(r));
    let corner = DVec2::new(-6.0, 4.0);
    let field = DistanceField::of(&stairs, corner, 0.1, [120, 80], 25.0).unwrap();
    for (p, d) in texels(&field, corner).filter(|t| t.0.y.abs() < 0.5 && t.0.x.abs() < 0.5) {
        let want = p.distance(DVec2::new(0.0, 1.0)).min(p.distance(DVec2::new(0.0, -1.0)));
        let want = if p.x > 0.0 { want.min(p.y + 1.0) } else { want.min(1.0 - p.y) };
        assert!((d - want / 0.1).abs() < 1e-4, "{p}: {d} for {want}");
    }
    // A hole stays one, whatever overlaps beside it.
    let mut holed = Outline::new();
    holed.add_rect(rect(-5.0, -2.0, 5.0, 2.0));
    holed.cut_rect(rect(-4.0, -1.0, 4.0, 1.0));
    let corner = DVec2::new(-6.0, 4.0);
    let field = DistanceField::of(&holed, corner, 0.1, [120, 80], 25.0).unwrap();
    for (p, d) in texels(&field, corner) {
        let want = to_square(p, DVec2::new(5.0, 2.0)).min(-to_square(p, DVec2::new(4.0, 1.0))) / 0.1;
        let corner_near = (p.abs() - DVec2::new(4.0, 1.0)).min_element() > 0.0;
        // Within the rim's corners the intersection's formula is only a bound.
        assert!(corner_near && d >= want - 1e-4 || (d - want.clamp(-25.0, 25.0)).abs() < 1e-4, "{p}: {d} for {want}");
    }
}

/// Winding by angles, distance to all boundary points found by sampling both: no code in common.
#[test]
fn random_tangles_agree_with_brute_force() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..12 {
        let mut outline = Outline::new();
        for _ in 0..4 {
            let n = rng.random_range(3..7);
            outline.add((0..n).map(|_| DVec2::new(rng.random_range(-5.0..5.0), rng.random_range(-5.0..5.0))).collect());
        }
        let winding = |p: DVec2| -> i32 {
            let angle =
                |c: &Vec<DVec2>| -> f64 { (0..c.len()).map(|i| (c[i] - p).angle_to(c[(i + 1) % c.len()] - p)).sum() };
            (outline.contours.iter().map(angle).sum::<f64>() / std::f64::consts::TAU).round() as i32
        };
        // Points along all sides that have outside on one hand only.
        let mut edge = Vec::new();
        for c in &outline.contours {
            for (i, &a) in c.iter().enumerate() {
                let b = c[(i + 1) % c.len()];
                for k in 0..800 {
                    let p = a.lerp(b, (f64::from(k) + 0.5) / 800.0);
                    let off = (b - a).perp().normalize() * 1e-6;
                    if (winding(p + off) != 0) != (winding(p - off) != 0) {
                        edge.push(p);
                    }
                }
            }
        }
        let corner = DVec2::new(-6.0, 6.0);
        let field = DistanceField::of(&outline, corner, 0.5, [24, 24], 10.0).unwrap();
        for (p, d) in texels(&field, corner) {
            let near = edge.iter().map(|e| e.distance(p)).fold(f64::MAX, f64::min) / 0.5;
            assert!((d.abs() - near.min(10.0)).abs() < 0.03, "{p}: {d} for {near}");
            assert!(d.abs() < 1e-3 || (d > 0.0) == (winding(p) != 0), "{p}: {d}, winding {}", winding(p));
        }
    }
}

#[test]
fn flattened_curves_are_within_their_tolerance() {
    let [a, b, c, d] = [[0.0, 0.0], [1.0, 2.0], [3.0, -2.0], [4.0, 1.0]].map(DVec2::from_array);
    let far = |points: &[DVec2], p: DVec2| {
        let to = |s: &[DVec2]| {
            let t = ((p - s[0]).dot(s[1] - s[0]) / (s[1] - s[0]).length_squared()).clamp(0.0, 1.0);
            p.distance(s[0].lerp(s[1], t))
        };
        points.windows(2).map(to).fold(f64::MAX, f64::min)
    };
    for tolerance in [0.1, 0.01, 0.001] {
        let mut cubic = vec![a];
        flatten_cubic(a, [b, c], d, tolerance, &mut cubic);
        let mut quadratic = vec![a];
        flatten_quadratic(a, b, c, tolerance, &mut quadratic);
        for k in 0..=200 {
            let (t, s) = (f64::from(k) / 200.0, 1.0 - f64::from(k) / 200.0);
            let on = s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d;
            assert!(far(&cubic, on) <= tolerance);
            assert!(far(&quadratic, s * s * a + 2.0 * s * t * b + t * t * c) <= tolerance);
        }
    }
}

fn halves(level: &Level) -> impl Iterator<Item = [f64; 2]> + '_ {
    level.bytes.chunks_exact(4).map(|b| [[b[0], b[1]], [b[2], b[3]]].map(|h| f16::from_le_bytes(h).to_f64()))
}

#[test]
fn coarser_levels_keep_mean_coverage_of_fill_and_halo() {
    let mut outline = Outline::new();
    outline.add_disc(DVec2::new(1.0, 0.0), 3.0, 200);
    // Thin enough to vanish under mean distances.
    outline.add_rect(rect(-9.0, -5.1, 9.0, -4.9));
    let paint = Paint { halo: Some(([255; 4], 0.4)), ..PLAIN };
    let sheet = Sheet::drawn(&outline, outline.bounds().unwrap(), 0.09, &paint).unwrap();
    let [w, h] = sheet.texture.size();
    assert!(w.count_ones() > 1 && h.count_ones() > 1, "sizes that are no powers of two expected, found {w} × {h}");
    let levels = sheet.texture.mips();
    assert_eq!(sheet.texture.format(), TexelFormat::Rg16Float);
    let cover = |level: &Level, k: usize, channel: usize| {
        let sum: f64 = halves(level).map(|v| (0.5 + v[channel] / f64::powi(2.0, k as i32)).clamp(0.0, 1.0)).sum();
        sum / (level.width * level.height) as f64
    };
    let Texture::Distance { field, .. } = &sheet.texture else { panic!() };
    let area = (std::f64::consts::PI * 9.0 + 18.0 * 0.2) / (w as f64 * h as f64 * field.texel_mm.powi(2));
    for channel in 0..2 {
        let first = cover(&levels[0], 0, channel);
        for (k, level) in levels.iter().enumerate() {
            assert_eq!(level.bytes.len(), 4 * level.width * level.height);
            assert_eq!([level.width, level.height], [(w >> k).max(1), (h >> k).max(1)]);
            let mean = cover(level, k, channel);
            assert!((mean - first).abs() < 1e-3, "channel {channel} level {k}: {mean} for {first}");
        }
        if channel == 0 {
            assert!((first - area).abs() < 2e-3, "{first} for {area}");
        }
    }
    let last = levels.last().unwrap();
    assert_eq!([last.width, last.height], [1, 1]);
    // The halo's distance is the fill's and its width.
    for v in halves(&levels[0]) {
        assert!((v[1] - v[0] - 0.4 / field.texel_mm).abs() < 0.02, "{v:?}");
    }
}

#[test]
fn an_images_levels_keep_premultiplied_means() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (w, h) = (37, 21);
    let straight: Vec<[u8; 4]> = (0..w * h).map(|_| rng.random()).collect();
    let image = Texture::image(w, h, &straight).unwrap();
    let mean = |channel: usize| {
        let sum: f64 = straight
            .iter()
            .map(|c| f64::from(c[channel]) * if channel < 3 { f64::from(c[3]) / 255.0 } else { 1.0 })
            .sum();
        sum / (w * h) as f64
    };
    let levels = image.mips();
    assert_eq!(
        levels.iter().map(|l| [l.width, l.height]).collect::<Vec<_>>(),
        [[37, 21], [18, 10], [9, 5], [4, 2], [2, 1], [1, 1]]
    );
    for level in &levels {
        for channel in 0..4 {
            let sum: f64 = level.bytes.chunks_exact(4).map(|c| f64::from(c[channel])).sum();
            let found = sum / (level.width * level.height) as f64;
            assert!((found - mean(channel)).abs() < 0.51, "{found} for {}", mean(channel));
        }
        assert!(level.bytes.chunks_exact(4).all(|c| c[..3].iter().all(|&x| x <= c[3])), "premultiplied");
    }
    // What is hidden does not bleed: clear green beside full red is half of red, not of a mixture.
    let edge = Texture::image(2, 1, &[[255, 0, 0, 255], [0, 255, 0, 0]]).unwrap().mips();
    assert_eq!(edge[1].bytes, [128, 0, 0, 128]);
    assert!(Texture::image(0, 3, &[]).is_err() && Texture::image(2, 2, &[[0; 4]; 3]).is_err());
    let sheet = Sheet::of_image(image, 74.0).unwrap();
    assert_eq!(sheet.size_mm, [74.0, 42.0]);
}

/// Signed distance at a place of the drawing, mm, by bilinear reading as a GPU would.
fn at(sheet: &Sheet, x: f64, y: f64) -> f64 {
    let Texture::Distance { field, .. } = &sheet.texture else { panic!() };
    let [w, h] = sheet.size_mm;
    let (u, v) = ((x + sheet.origin_mm[0]) / w, 1.0 - (y + sheet.origin_mm[1]) / h);
    let m = sheet.texture_from_uv;
    let t = DVec2::from_array(m[0]) * u + DVec2::from_array(m[1]) * v + DVec2::from_array(m[2]);
    let p = t * DVec2::new(field.width as f64, field.height as f64) - 0.5;
    let (i, f) = (p.floor(), p - p.floor());
    let texel = |dx: i64, dy: i64| {
        let (x, y) =
            ((i.x as i64 + dx).rem_euclid(field.width as i64), (i.y as i64 + dy).rem_euclid(field.height as i64));
        f64::from(field.texels[y as usize * field.width + x as usize])
    };
    let row = |dy| texel(0, dy) * (1.0 - f.x) + texel(1, dy) * f.x;
    (row(0) * (1.0 - f.y) + row(1) * f.y) * field.texel_mm
}

#[test]
fn patterns_are_those_of_their_equations_at_any_angle() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    // From the nearest multiple of a period.
    let off = |x: f64, period: f64| (x - (x / period).round() * period).abs();
    for angle_deg in [0.0f64, 30.0, 45.0, 117.3, -10.0] {
        let lines = Figure::Lines { spacing_mm: 2.0, width_mm: 0.3 };
        let cross = Figure::Cross { spacing_mm: 2.0, width_mm: 0.3 };
        let dots = Figure::Dots { spacing_mm: 2.0, diameter_mm: 0.8 };
        let checker = Figure::Checker { side_mm: 1.5 };
        let sheet = |figure| Hatch { figure, angle_deg, size_mm: [40.0, 25.0] }.sheet(&PLAIN).unwrap();
        let sheets = [lines, cross, dots, checker].map(sheet);
        for _ in 0..2000 {
            let (x, y) = (rng.random_range(-20.0..20.0), rng.random_range(-12.5..12.5));
            // Along the pattern's axes: a line to the right at 0, turned counter-clockwise.
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let (a, b) = (x * cos + y * sin, y * cos - x * sin);
            let (row, column) = (0.15 - off(b, 2.0), 0.15 - off(a, 2.0));
            let dot = |shift: f64| 0.4 - off(a + shift, 2.0).hypot(off(b + shift * 3f64.sqrt(), 2.0 * 3f64.sqrt()));
            let square = ((a / 1.5).floor() + (b / 1.5).floor()).rem_euclid(2.0) == 0.0;
            let side = off(a, 1.5).min(off(b, 1.5));
            for (sheet, want) in
                sheets.iter().zip([row, row.max(column), dot(0.0).max(dot(1.0)), if square { side } else { -side }])
            {
                let Texture::Distance { field, .. } = &sheet.texture else { panic!() };
                let found = at(sheet, x, y);
                // Distance to a corner from outside and the bend between two texels differ; the edge may not.
                assert!(
                    found * want > 0.0 || want.abs() < 0.8 * field.texel_mm,
                    "{angle_deg}° ({x}, {y}): {found} for {want}"
                );
            }
            assert!((at(&sheets[0], x, y) - row).abs() < 0.02);
        }
    }
    let wrong = Hatch { figure: Figure::Lines { spacing_mm: 1.0, width_mm: 2.0 }, angle_deg: 0.0, size_mm: [1.0, 1.0] };
    assert!(wrong.sheet(&PLAIN).unwrap_err().to_string().contains("under the spacing"));
}

#[test]
fn a_ruler_is_as_long_as_it_says_with_ticks_where_they_belong() {
    let ruler = Ruler {
        length_mm: 23.4,
        thickness_mm: 0.2,
        tick_spacing_mm: Some(2.0),
        longer_every: 5,
        tick_height_mm: 3.0,
        label: length_in_words(23.4),
        label_size_mm: 3.0,
    };
    assert_eq!(
        [23.4, 123.0, 2.5, 0.5, 9.9999].map(length_in_words),
        ["23.4 mm", "123.0 mm", "2.50 mm", "0.500 mm", "10.0 mm"]
    );
    let sheet = ruler.sheet(&shipped(), &PLAIN).unwrap();
    assert!(sheet.missing.is_empty());
    // Outer faces of the ends.
    for x in [-11.7, 11.7] {
        assert!(at(&sheet, x, -1.0).abs() < 2e-3 && at(&sheet, x, 1.2).abs() < 2e-3, "{}", at(&sheet, x, -1.0));
    }
    for n in 1..12 {
        let x = -11.7 + 2.0 * f64::from(n);
        let high = if n % 5 == 0 { 1.05 } else { 0.675 };
        assert!((at(&sheet, x + 0.1, 0.4)).abs() < 5e-3, "tick {n}");
        assert!((at(&sheet, x, high)).abs() < 5e-3, "top of tick {n}: {}", at(&sheet, x, high));
        assert!(at(&sheet, x, -0.2) < 0.0 && at(&sheet, x + 1.0, 0.5) < -0.1);
    }
    let many = Ruler { tick_spacing_mm: Some(1e-3), ..ruler.clone() };
    assert!(many.sheet(&shipped(), &PLAIN).unwrap_err().to_string().contains("at least"));
    let bar = ScaleBar { length_mm: 20.0, parts: 4, height_mm: 1.2, thickness_mm: 0.15, label_size_mm: 2.0 };
    let bar = bar.sheet(&shipped(), &PLAIN).unwrap();
    assert!(
        [-7.5, 2.5].iter().all(|&x| at(&bar, x, 0.0) > 0.14) && [-2.5, 7.5].iter().all(|&x| at(&bar, x, 0.0) < -0.14)
    );
    assert!(at(&bar, 10.0, 0.0).abs() < 2e-3 && at(&bar, -10.0, 0.0).abs() < 2e-3);
}

#[test]
fn arrows_point_to_the_right_and_frames_are_hollow() {
    let arrow = Arrow { length_mm: 10.0, thickness_mm: 0.4, head_length_mm: 2.0, head_width_mm: 1.6, both_ends: false };
    let sheet = arrow.sheet(&PLAIN).unwrap();
    assert!(at(&sheet, 3.2, 0.6) > 0.0 && at(&sheet, -3.2, 0.6) < -0.2);
    assert!((at(&sheet, 0.0, 0.0) - 0.2).abs() < 0.03 && at(&sheet, 0.0, -0.2).abs() < 2e-3);
    // Texture rows run downwards, columns to the right: the same in raw texels.
    let Texture::Distance { field, .. } = &sheet.texture else { panic!() };
    let full = |columns: std::ops::Range<usize>| {
        columns.map(|x| (0..field.height).filter(|y| field.texels[y * field.width + x] > 0.0).count()).max().unwrap()
    };
    assert!(full(field.width / 2..field.width) > 2 * full(0..field.width / 2));
    let both = Arrow { both_ends: true, ..arrow }.sheet(&PLAIN).unwrap();
    assert!(at(&both, 3.2, 0.6) > 0.0 && at(&both, -3.2, 0.6) > 0.0);
    assert!(Arrow { head_length_mm: 11.0, ..arrow }.sheet(&PLAIN).is_err());
    let frame = Frame { size_mm: [10.0, 6.0], thickness_mm: 0.5, corner_mm: 1.0 }.sheet(&PLAIN).unwrap();
    assert!(at(&frame, 0.0, 0.0) < -0.4 && at(&frame, 4.75, 0.0) > 0.2 && at(&frame, 4.95, 2.95) < 0.0);
    // 1 mm of radius about (4, 2).
    let diagonal = DVec2::new(4.0, 2.0) + DVec2::splat(0.5f64.sqrt());
    assert!(at(&frame, diagonal.x, diagonal.y).abs() < 2e-3);
}

#[test]
fn what_is_too_large_is_coarser_and_what_is_no_length_is_refused() {
    let mut long = Outline::new();
    long.add_rect(rect(-500.0, -0.5, 500.0, 0.5));
    let sheet = Sheet::drawn(&long, long.bounds().unwrap(), 0.01, &PLAIN).unwrap();
    assert!(sheet.texture.size()[0] <= MAX_SIDE && sheet.size_mm[0] >= 1000.0);
    let paint = |mm| Paint { halo: Some(([0; 4], mm)), ..PLAIN };
    for mm in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(Sheet::drawn(&long, long.bounds().unwrap(), 0.01, &paint(mm)).is_err());
    }
    // A halo of any width has room.
    let sheet = Sheet::drawn(&long, long.bounds().unwrap(), 0.01, &paint(30.0)).unwrap();
    let Texture::Distance { field, .. } = &sheet.texture else { panic!() };
    assert!(field.spread * field.texel_mm > 30.0 && sheet.size_mm[1] > 61.0);
    let nothing = Outline::new();
    let empty = Sheet::drawn(&nothing, rect(0.0, 0.0, 1.0, 1.0), 0.1, &PLAIN).unwrap();
    let Texture::Distance { field, .. } = &empty.texture else { panic!() };
    assert!(field.texels.iter().all(|&d| f64::from(d) == -field.spread));
    let mirrored = long.mapped(&DAffine2::from_scale(DVec2::new(-1.0, 1.0)));
    assert_eq!(boundary(&mirrored).len(), 4);
}
