//! Refined volume rendering by the book: stretch by stretch, in f64, for bodies that do not overlap.
//!
//! Written from what a stretch is: from sample to sample of the lattice, begun where the ray enters a body and ended where it
//! leaves; halved where a step of its matter would add more than 1/40; of two steps where less than 1/16 comes through. In it
//! density goes evenly from end to end. Its extinction is the mean of the transfer function's over it, its colour that of the
//! density in the middle of its extinction, its light the mean over as far as that middle is from the nearer end, with the
//! gradient going evenly too. Where looks go by label all of it has that of the voxel in its middle.

use super::reference::{Event, Met, NOTHING, Pixel, lay, painted, weight};
use burin::gpu::{Frame, LookRef};
use burin::math::{DVec3, Ray};

/// Places at which a stretch is summed up.
const PLACES: usize = 240;

/// What lies in a stretch: mean extinction of a step, and where its middle is as a share of the way.
fn between(look: LookRef<'_>, step_mm: f64, s0: f64, s1: f64) -> (f64, f64) {
    let (mut sum, mut moment) = (0.0, 0.0);
    for i in 0..PLACES {
        let u = (i as f64 + 0.5) / PLACES as f64;
        let thin = f64::from(look.transfer.opacity_at(s0 + (s1 - s0) * u)) * f64::from(look.opacity);
        let extinction = (-(1.0 - thin).ln() * step_mm / look.transfer.unit_mm).min(50.0);
        sum += extinction;
        moment += extinction * u;
    }
    if sum > 0.0 { (sum / PLACES as f64, moment / sum) } else { (0.0, 0.5) }
}

/// The headlight's mean on a colour, the gradient going from `a` to `b`.
fn lit(look: LookRef<'_>, rgb: [f64; 3], ray: &Ray, [a, b]: [DVec3; 2], share: f64) -> [f64; 3] {
    let Some(light) = look.lighting else { return rgb };
    let reach = share.min(1.0 - share);
    let (mut plain, mut white) = (0.0, 0.0);
    for i in 0..PLACES {
        let u = share + reach * ((2 * i + 1) as f64 / PLACES as f64 - 1.0);
        let g = a + (b - a) * u;
        let c = if g == DVec3::ZERO { 1.0 } else { g.normalize().dot(ray.dir).abs() };
        plain += c / PLACES as f64;
        white += c.powf(f64::from(light.power)) / PLACES as f64;
    }
    let diffuse = f64::from(light.ambient) + f64::from(light.diffuse) * plain;
    rgb.map(|x| x * diffuse + f64::from(light.specular) * white)
}

/// A pixel; the bodies' intervals must not overlap. Stretches end and begin at events, in order along the ray.
pub(super) fn refined(frame: &Frame, met: &[Met<'_>], events: Vec<Event>, ray: &Ray) -> Pixel {
    let step = frame.step_mm;
    let mut pieces: Vec<(f64, f64, &Met<'_>)> = Vec::new();
    for m in met {
        let cuts = events.iter().map(|e| e.at).filter(|at| (m.entry..m.exit).contains(at) && *at > m.entry);
        let mut from = m.entry;
        for to in cuts.chain([m.exit]) {
            pieces.push((from, to, m));
            from = to;
        }
    }
    pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pixel = NOTHING;
    let mut clear = 1.0;
    let mut events = events.into_iter().peekable();
    for (entry, exit, m) in pieces {
        while let Some(e) = events.next_if(|e| e.at <= entry && clear >= 1.0 / 256.0) {
            lay(&mut pixel, &mut clear, (e.rgb, e.alpha), e.depth_mm, e.object);
        }
        let dense = m.dense;
        let gradient = |t: f64| {
            let g = dense.gradient(|p| dense.density(p), m.at(t));
            m.body.pose.rotation * (m.index_from_world.transpose() * g)
        };
        let (entry, exit) = (entry / step, exit / step);
        let mut begin = entry;
        let mut k = entry.ceil();
        let mut last: Option<(f64, DVec3)> = None;
        while begin < exit && clear >= 1.0 / 256.0 {
            let end = k.min(exit);
            let (s0, s1) = (dense.density(m.at(begin * step)), dense.density(m.at(end * step)));
            let number = !(s0.is_nan() || s1.is_nan());
            let look = m.look(m.at((begin + end) / 2.0 * step)).filter(|_| number);
            let (mean, share) = look.map_or((0.0, 0.5), |look| between(look, step, s0, s1));
            let much = clear * mean.min(1.0) > 1.0 / 40.0;
            let whole = k.fract() == 0.0;
            if much && whole && k - 0.5 > begin && k - 0.5 < exit {
                k -= 0.5;
                continue;
            }
            if let Some(look) = look.filter(|_| mean > 0.0) {
                let p = m.at((begin + share * (end - begin)) * step);
                let own = mean * (end - begin) * weight(m.body.mask, dense.selection(p));
                let value = s0 + (s1 - s0) * share;
                let mut rgb = painted(dense, frame, m.body, look.transfer.colour_at(value), p);
                if look.lighting.is_some() {
                    let b = gradient(end * step);
                    let a = last.filter(|l| l.0 == begin).map_or(b, |l| l.1);
                    rgb = lit(look, rgb, ray, [a, b], share);
                    last = Some((end, b));
                }
                let alpha = 1.0 - f64::exp(-own);
                for (i, c) in rgb.iter().enumerate() {
                    pixel.colour[i] += clear * alpha * c;
                }
                if clear > 0.5 && clear * (1.0 - alpha) <= 0.5 {
                    pixel.depth_mm = (begin + share * (end - begin)) * step;
                    pixel.object = m.body.id + 1;
                }
                clear *= 1.0 - alpha;
            }
            begin = end;
            k += match () {
                () if much || !whole => 0.5,
                () if mean > 0.0 && clear < 1.0 / 16.0 && k + 2.0 <= exit.ceil() => 2.0,
                () => 1.0,
            };
        }
    }
    for e in events {
        if clear >= 1.0 / 256.0 {
            lay(&mut pixel, &mut clear, (e.rgb, e.alpha), e.depth_mm, e.object);
        }
    }
    pixel.colour[3] = 1.0 - clear;
    pixel
}
