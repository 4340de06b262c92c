//! Shaping against uharfbuzz's answers for the same font, setting against closed forms, and hostile input.

use burin::annotate::picture::fonts::{FontBytes, Fonts};
use burin::annotate::picture::shapes::text_sheet;
use burin::annotate::picture::shaping::{ShapedLine, shape_line};
use burin::annotate::picture::sheet::Paint;

use burin::annotate::picture::text::{Align, Baseline, MAX_CHARACTERS, Text, radius_of_sagitta};
use burin::annotate::picture::texture::Texture;
use glam::DVec2;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::borrow::Cow;
use std::collections::BTreeSet;

const DEJAVU: &[u8] = include_bytes!("../../assets/fonts/DejaVuSans.ttf");
const PLAIN: Paint = Paint { fill: [0, 0, 0, 255], halo: None };

fn font(bytes: impl Into<Cow<'static, [u8]>>) -> FontBytes {
    FontBytes { name: "DejaVu Sans".into(), bytes: bytes.into(), index: 0 }
}

fn shipped() -> Fonts {
    Fonts::new(vec![font(DEJAVU)]).unwrap()
}

fn shaped(text: &str) -> ShapedLine {
    let mut missing = BTreeSet::new();
    let line = shape_line(&shipped(), text, &mut missing);
    assert!(missing.is_empty(), "{missing:?}");
    line
}

/// Glyph, advance, x and y offset in font units, as uharfbuzz tells them.
fn units(line: &ShapedLine) -> Vec<(u32, i32, i32, i32)> {
    let of = |em: f64| (em * 2048.0).round() as i32;
    line.glyphs.iter().map(|g| (g.glyph.unwrap(), of(g.advance_em), of(g.offset_em[0]), of(g.offset_em[1]))).collect()
}

/// uharfbuzz 0.57 with DejaVu Sans 2.37: Buffer.add_str, guess_segment_properties, shape.
#[test]
fn shaping_is_harfbuzzs() {
    // Kerned: twice the advance of A (1401) and that of V (1401), less 262.
    assert_eq!(units(&shaped("AVA")), [(36, 1270, 0, 0), (57, 1270, 0, 0), (36, 1401, 0, 0)]);
    assert_eq!(units(&shaped("سلام")), [(1390, 1268, 0, 0), (5366, 1222, 0, 0), (5293, 1716, 0, 0)]);
    let hebrew = [
        (1332, 1359, 0, 0),
        (1306, 0, 0, 0),
        (1324, 558, 0, 0),
        (1331, 1164, 0, 0),
        (1305, 0, 0, 0),
        (1314, 0, 0, 0),
        (1344, 1451, 0, 0),
    ];
    assert_eq!(units(&shaped("\u{5e9}\u{5b8}\u{5c1}\u{5dc}\u{5d5}\u{5b9}\u{5dd}")), hebrew);
    assert_eq!(units(&shaped("e\u{323}\u{301}x")), [(2487, 1260, 0, 0), (690, 0, 0, 0), (91, 1212, 0, 0)]);
    let marks = [
        (1401, 0, -272, -600),
        (5340, 1363, 0, 0),
        (1403, 0, 138, -300),
        (5294, 1827, 0, 0),
        (1401, 0, -213, -350),
        (5259, 570, 0, 0),
    ];
    assert_eq!(units(&shaped("\u{628}\u{650}\u{633}\u{652}\u{645}\u{650}")), marks);
    let ligatures =
        [(5042, 1290, 0, 0), (3, 651, 0, 0), (82, 1253, 0, 0), (5044, 1980, 0, 0), (70, 1126, 0, 0), (72, 1260, 0, 0)];
    assert_eq!(units(&shaped("fi office")), ligatures);
}

#[test]
fn arabic_letters_join_and_run_from_right_to_left() {
    let line = shaped("سلام");
    assert!(line.right_to_left && line.glyphs.windows(2).all(|g| g[0].cluster > g[1].cluster));
    let alone: Vec<u32> = "سلام".chars().map(|c| shaped(&c.to_string()).glyphs[0].glyph.unwrap()).collect();
    // Lam and alef are one glyph; seen has its initial form; meem behind alef stands alone.
    assert_eq!(line.glyphs.len(), 3);
    assert!(line.glyphs[1..].iter().all(|g| !alone.contains(&g.glyph.unwrap())));
    assert_eq!(line.glyphs[0].glyph, Some(alone[3]));
    assert!(line.glyphs.iter().all(|g| g.joins));
}

#[test]
fn mixed_text_is_ordered_by_the_bidirectional_algorithm() {
    // UAX 9: in a line from left to right the Hebrew words stand reversed as one, numbers keep their order, brackets are mirrored.
    let line = shaped("ab (אב 12) cd");
    let order: Vec<usize> = line.glyphs.iter().map(|g| g.cluster).collect();
    let byte = |c: char| "ab (אב 12) cd".find(c).unwrap();
    let place = |c: char| order.iter().position(|&o| o == byte(c)).unwrap();
    assert!(!line.right_to_left);
    assert!(place('a') < place('b') && place('b') < place('(') && place('c') < place('d'));
    assert!(place('ב') < place('א') && place('1') < place('2') && place('2') < place('ב'), "{order:?}");
    assert!(place('(') < place('2') && place('א') < place(')'));
    // In a line from right to left an opening bracket comes first, at the right, and looks like a closing one.
    let line = shaped("(אב)");
    let right = line.glyphs.last().unwrap();
    assert!(line.right_to_left && right.cluster == 0);
    assert_eq!(right.glyph, shaped("a)").glyphs[1].glyph);
    // Two scripts of a line from right to left: the first one stands at the right.
    let line = shaped("אב سلم");
    assert!(line.glyphs.windows(2).all(|g| g[0].cluster > g[1].cluster), "{line:?}");
    // Format characters are not seen.
    assert_eq!(shaped("a\u{200b}b\u{2067}").width_em, shaped("ab").width_em);
}

#[test]
fn marks_stand_over_their_letters() {
    let text = |t: &str| Text::new(t, 10.0).set(&shipped()).unwrap();
    let (plain, marked) = (text("q"), text("q\u{301}"));
    let (p, m) = (plain.outline.bounds().unwrap(), marked.outline.bounds().unwrap());
    assert_eq!(plain.line_widths_mm, marked.line_widths_mm);
    assert!(m.max.y > p.max.y + 1.0 && m.min.x >= p.min.x - 0.5 && m.max.x <= p.max.x + 0.5);
}

#[test]
fn nothing_is_mirrored() {
    // An L has its stem at the left and its foot at the bottom, in raw texels too: rows run downwards.
    let sheet = text_sheet(&Text::new("L", 10.0), &shipped(), &PLAIN).unwrap();
    let Texture::Distance { field, .. } = &sheet.texture else { panic!() };
    let ink: Vec<(usize, usize)> = (0..field.texels.len())
        .filter(|&i| field.texels[i] > 0.0)
        .map(|i| (i % field.width, i / field.width))
        .collect();
    let (left, right) = (ink.iter().map(|p| p.0).min().unwrap(), ink.iter().map(|p| p.0).max().unwrap());
    let (top, bottom) = (ink.iter().map(|p| p.1).min().unwrap(), ink.iter().map(|p| p.1).max().unwrap());
    assert!(
        ink.contains(&(left + 4, top + 4))
            && ink.contains(&(left + 4, bottom - 4))
            && ink.contains(&(right - 4, bottom - 4))
    );
    assert!(!ink.contains(&(right - 4, top + 4)));
    // 96 texels an em: the stem is 0.729 em high.
    assert!((bottom - top + 1).abs_diff(70) <= 1);
}

/// The middle of a glyph's foot: its outline's lowest points about the baseline.
fn stems(text: &Text) -> Vec<[DVec2; 2]> {
    text.set(&shipped()).unwrap().outline.contours.iter().map(|c| [c[0], c[1]]).collect()
}

#[test]
fn a_bent_baseline_keeps_advances_along_the_arc_and_letters_upright_on_it() {
    // One stroke a letter, of one contour each: the first corner of each is the same point of the glyph.
    let word = "llllllll";
    let advance = shaped("l").width_em * 10.0;
    // Alone it stands on the middle of the arc, upright.
    let alone = |baseline| Text { baseline, ..Text::new("l", 10.0) }.set(&shipped()).unwrap().outline;
    for (b, s) in alone(Baseline::Radius(40.0)).contours[0].iter().zip(&alone(Baseline::Straight).contours[0]) {
        assert!(b.distance(*s) < 1e-9);
    }
    for radius in [40.0, -40.0] {
        let bent = stems(&Text { baseline: Baseline::Radius(radius), ..Text::new(word, 10.0) });
        let straight = stems(&Text::new(word, 10.0));
        let centre = DVec2::new(0.0, -radius);
        for (b, s) in
            bent.iter().zip(&straight).collect::<Vec<_>>().windows(2).map(|w| ([w[0].0, w[1].0], [w[0].1, w[1].1]))
        {
            let angle = (b[0][0] - centre).angle_to(b[1][0] - centre);
            assert!((angle.abs() * 40.0 - advance).abs() < 1e-9, "{angle}");
            assert!((angle < 0.0) == (radius > 0.0), "to the right: {angle}");
            // Rigid: sides keep their lengths.
            assert!((b[0][0].distance(b[0][1]) - s[0][0].distance(s[0][1])).abs() < 1e-9);
        }
        // The middle is the highest point of an arch, the lowest of a bowl; all is above the arc's own side.
        let ys: Vec<f64> = bent.iter().map(|b| b[0].y).collect();
        assert!(if radius > 0.0 { ys[4] > ys[0] && ys[4] > ys[7] } else { ys[4] < ys[0] && ys[4] < ys[7] });
    }
}

#[test]
fn joined_letters_bend_and_keep_their_heights() {
    // Bars between two letters; bent, every point keeps its height over the arc.
    let word = "\u{628}\u{640}\u{640}\u{640}\u{640}\u{640}\u{640}\u{628}";
    let straight = Text::new(word, 10.0).set(&shipped()).unwrap();
    let text = Text { baseline: Baseline::Radius(30.0), ..Text::new(word, 10.0) };
    let bent = text.set(&shipped()).unwrap();
    let bar = Text::new("\u{640}", 10.0).set(&shipped()).unwrap().outline.bounds().unwrap();
    let s = straight.outline.bounds().unwrap();
    let centre = DVec2::new(0.0, -30.0);
    for p in bent.outline.contours.iter().flatten() {
        let up = p.distance(centre) - 30.0;
        assert!(up > s.min.y - 1e-6 && up < s.max.y + 1e-6);
    }
    // One bar: no seam where its parts meet.
    let sheet = text_sheet(&text, &shipped(), &PLAIN).unwrap();
    let Texture::Distance { field, .. } = &sheet.texture else { panic!() };
    let half = 0.5 * (bar.max.y - bar.min.y) / field.texel_mm;
    let along = 0.5 * (bar.max.y + bar.min.y) + 30.0;
    // Over the inner four bars, their joints among them.
    let reach = 1.5 * bar.size().x / 30.0;
    for k in -60..=60 {
        let angle = f64::from(k) / 60.0 * reach;
        let p = centre + along * DVec2::new(angle.sin(), angle.cos());
        let (x, y) = (p.x + sheet.origin_mm[0], sheet.size_mm[1] - p.y - sheet.origin_mm[1]);
        let d = field.texels[(y / field.texel_mm) as usize * field.width + (x / field.texel_mm) as usize];
        assert!(f64::from(d) > half - 0.75, "{angle}: {d} for {half}");
    }
}

#[test]
fn a_sagitta_is_that_of_its_arc() {
    for (sagitta, length) in [(1.0, 20.0), (-3.0, 20.0), (7.0, 20.0), (0.001, 20.0)] {
        let radius = radius_of_sagitta(sagitta, length).unwrap();
        let half_angle = 0.5 * length / radius.abs();
        assert!((radius.abs() * (1.0 - half_angle.cos()) - f64::abs(sagitta)).abs() < 1e-6);
        assert_eq!(radius > 0.0, sagitta > 0.0);
    }
    assert_eq!(radius_of_sagitta(0.0, 20.0), None);
    let bent = |b| Text { baseline: b, ..Text::new("a longer text", 10.0) }.set(&shipped());
    assert!(bent(Baseline::Sagitta(60.0)).unwrap_err().to_string().contains("at most"));
    assert!(bent(Baseline::Radius(4.0)).unwrap_err().to_string().contains("at least"));
    assert!(bent(Baseline::Radius(f64::NAN)).is_err() && bent(Baseline::Sagitta(f64::INFINITY)).is_err());
    assert_eq!(bent(Baseline::Sagitta(0.0)), bent(Baseline::Straight));
}

#[test]
fn lines_are_aligned() {
    let left = |align, text: &str| {
        let set = Text { align, ..Text::new(text, 10.0) }.set(&shipped()).unwrap();
        let (top, bottom): (Vec<_>, Vec<_>) = set.outline.contours.iter().flatten().partition(|p| p.y > -3.0);
        let span = |v: Vec<&DVec2>| v.iter().fold((f64::MAX, f64::MIN), |a, p| (a.0.min(p.x), a.1.max(p.x)));
        (span(top), span(bottom))
    };
    let (top, bottom) = left(Align::Start, "HHHHH\nH");
    assert!((top.0 - bottom.0).abs() < 1e-9 && top.1 > bottom.1 + 10.0);
    let (top, bottom) = left(Align::Middle, "HHHHH\nH");
    assert!((top.0 + top.1 - bottom.0 - bottom.1).abs() < 1e-9);
    let (top, bottom) = left(Align::End, "HHHHH\nH");
    assert!((top.1 - bottom.1).abs() < 1e-9 && bottom.0 > top.0 + 10.0);
    // A line from right to left begins at the right.
    let (top, bottom) = left(Align::Start, "HHHHH\nם");
    assert!(bottom.0 > top.0 + 10.0);
}

#[test]
fn missing_characters_are_told_and_drawn_as_boxes() {
    let text = Text::new("no 骨 \u{200d}ओ骨", 10.0);
    let sheet = text_sheet(&text, &shipped(), &PLAIN).unwrap();
    assert_eq!(sheet.missing, ['ओ', '骨']);
    assert_eq!(shipped().missing("no 骨\u{200d}ओ骨\n"), ['ओ', '骨']);
    let one = Text::new("骨", 10.0).set(&shipped()).unwrap();
    assert_eq!((one.outline.contours.len(), one.missing.as_slice()), (2, ['骨'].as_slice()));
    assert!(Text::new("all here", 10.0).set(&shipped()).unwrap().missing.is_empty());
}

/// A font without the letters from `m` on: another table of characters stands in the place of its own.
fn first_letters() -> FontBytes {
    let mut bytes = DEJAVU.to_vec();
    let record = (0..).map(|n| 12 + 16 * n).find(|&r| &bytes[r..r + 4] == b"cmap").unwrap();
    let at = u32::from_be_bytes(bytes[record + 8..record + 12].try_into().unwrap()) as usize;
    // One encoding (Windows, all of Unicode), a table of format 12 with one group: 'a' to 'l' are glyphs 68 to 79.
    let cmap: [u16; 20] = [0, 1, 3, 10, 0, 12, 12, 0, 0, 28, 0, 0, 0, 1, 0, 97, 0, 108, 0, 68];
    bytes[at..at + 2 * cmap.len()].copy_from_slice(&cmap.iter().flat_map(|n| n.to_be_bytes()).collect::<Vec<_>>());
    font(bytes)
}

#[test]
fn the_first_font_that_has_a_character_draws_it() {
    let fonts = Fonts::new(vec![first_letters(), font(DEJAVU)]).unwrap();
    let mut missing = BTreeSet::new();
    let line = shape_line(&fonts, "ab xy le\u{301}", &mut missing);
    let used: Vec<usize> = line.glyphs.iter().map(|g| g.font).collect();
    // The space stays in no font that lacks it; the accent takes its letter along.
    assert_eq!(used, [0, 0, 1, 1, 1, 1, 0, 1]);
    assert!(missing.is_empty());
    assert!(fonts.missing("xyz").is_empty());
    assert_eq!(Fonts::new(vec![first_letters()]).unwrap().missing("abz"), ['z']);
}

#[test]
fn fonts_that_are_none_are_named() {
    assert!(Fonts::new(vec![]).is_err());
    for bytes in [vec![], vec![0; 40], b"not a font at all, only words".to_vec(), DEJAVU[..3000].to_vec()] {
        let error = Fonts::new(vec![font(bytes)]).unwrap_err().to_string();
        assert!(error.contains("DejaVu Sans"), "{error}");
    }
    assert!(Fonts::new(vec![FontBytes { index: 3, ..font(DEJAVU) }]).is_err());
}

#[test]
fn hostile_fonts_never_stop_the_program() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let rounds = std::env::var("BURIN_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(150);
    let count = u16::from_be_bytes([DEJAVU[4], DEJAVU[5]]) as usize;
    let tables: Vec<(usize, usize)> = (0..count)
        .map(|n| {
            let of = |at: usize| u32::from_be_bytes(DEJAVU[12 + 16 * n + at..][..4].try_into().unwrap()) as usize;
            (of(8), of(12))
        })
        .collect();
    let mut drawn = 0;
    for _ in 0..rounds {
        let mut bytes = DEJAVU.to_vec();
        for _ in 0..rng.random_range(1..40) {
            // Mostly the beginnings of tables, where what counts stands.
            let (at, length) = tables[rng.random_range(0..count)];
            let within = if rng.random_bool(0.7) { length.min(64) } else { length };
            let at = if rng.random_bool(0.05) { rng.random_range(0..300) } else { at + rng.random_range(0..within) };
            bytes[at] = if rng.random_bool(0.3) { 0xff } else { rng.random() };
        }
        if rng.random_bool(0.1) {
            bytes.truncate(rng.random_range(0..bytes.len()));
        }
        if let Ok(fonts) = Fonts::new(vec![font(bytes)]) {
            let text = Text::new("AVA fi سلام שָׁלוֹם e\u{323}\u{301} हि Ѐ\nx", 10.0);
            drawn += usize::from(text_sheet(&text, &fonts, &PLAIN).is_ok());
        }
    }
    assert!(drawn > rounds / 10, "{drawn} of {rounds}");
}

#[test]
fn long_and_strange_texts_are_answered() {
    let fonts = shipped();
    let long = "ab ".repeat(40_000);
    let error = Text::new(long, 10.0).set(&fonts).unwrap_err().to_string();
    assert!(error.contains("120000 characters") && error.contains("at most 2000"), "{error}");
    let most = "Wم".repeat(MAX_CHARACTERS / 2);
    assert!(text_sheet(&Text::new(most, 10.0), &fonts, &PLAIN).is_ok());
    for text in [
        "",
        "\n\n",
        "\u{202e}\u{202e}\u{2066}",
        "\r\n\t\0\u{7f}",
        "\u{301}\u{301}",
        "\u{2029}a\u{2028}b",
        "\u{10ffff}\u{feff}",
    ] {
        assert!(text_sheet(&Text::new(text, 10.0), &fonts, &PLAIN).is_ok(), "{text:?}");
    }
    let marks = format!("a{}", "\u{301}".repeat(1_900));
    assert!(text_sheet(&Text::new(marks, 10.0), &fonts, &PLAIN).is_ok());
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
        assert!(Text::new("a", size).set(&fonts).is_err());
    }
    for size in [1e-6, 1e6] {
        assert!(text_sheet(&Text::new("a", size), &fonts, &PLAIN).is_ok());
    }
}

#[test]
fn the_same_text_is_the_same_texture() {
    let text = Text { baseline: Baseline::Sagitta(4.0), ..Text::new("Sinus سلام", 10.0) };
    let once = text_sheet(&text, &shipped(), &PLAIN).unwrap();
    assert_eq!(once, text_sheet(&text, &shipped(), &PLAIN).unwrap());
}

#[test]
fn fonts_of_folders_are_found_by_their_characters() {
    let folder = std::env::temp_dir().join(format!("burin-fonts-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("deeper")).unwrap();
    std::fs::write(folder.join("deeper/b.ttf"), DEJAVU).unwrap();
    std::fs::write(folder.join("a.ttf"), &*first_letters().bytes).unwrap();
    std::fs::write(folder.join("broken.otf"), b"OTTO").unwrap();
    std::fs::write(folder.join("none.txt"), DEJAVU).unwrap();
    let found = |wanted: &[char]| burin::io::fonts_for(wanted, std::slice::from_ref(&folder), 4);
    let fonts = found(&['a', 'م', '骨']);
    assert_eq!(fonts.len(), 1);
    assert!(
        fonts[0].path.ends_with("b.ttf") && fonts[0].characters == ['a', 'م'] && fonts[0].bytes().unwrap() == DEJAVU
    );
    assert!(found(&['a'])[0].path.ends_with("a.ttf"));
    assert!(found(&['骨']).is_empty() && found(&[]).is_empty());
    std::fs::remove_dir_all(&folder).unwrap();
}
