//! Labels that follow a moving scene.
//!
//! Labels keep their order and follow their points up and down by at most a stride per step. Because leaders bend round the points
//! that they pass, no order is ever wrong, only long: so changes of side and of places wait until they are worth it, and until the
//! last round of changes is a while ago, which is why labels are at rest more often than not. A label that changes its place fades
//! out, and in where room has been made for it, so nothing overlaps or crosses meanwhile either. Owns the frame's course; what is
//! remembered is [`Memory`]'s.

use crate::annotate::labels::board::{Board, lowest_first, sorted_out};
use crate::annotate::labels::change::{exchange, grant, swap, wish};
use crate::annotate::labels::column::Stand;
use crate::annotate::labels::leader::{burden, route_both};
use crate::annotate::labels::memory::{Entry, Kind, Memory, Stage, Tag};
use crate::annotate::labels::still::{arrange, ends};
use crate::annotate::labels::types::{Frame, Label, Placed, Reason, Style, Viewport};
use glam::{DMat3, DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// Points that go farther than this in one frame, on average, px, are another view: labels are placed anew.
const CUT: f64 = 60.0;

/// An edge stays as long as the outline comes no nearer than the margin and is no farther off than that and this, px.
const LAZY_EDGE: f64 = 24.0;

/// Labels that stand still are placed anew if that makes their leaders this much shorter and straighter.
const TIDIER: f64 = 0.9;

/// Places labels in the next frame of a moving scene, `dt_s` seconds after the last.
///
/// A step of the scene is a call whose labels differ from the last call's: until the next, no label goes farther than
/// `style.stride` but by a change of side or an exchange with a neighbour, however many calls follow. In the first frame, and after
/// a cut or a change of the picture's size or the style, labels are placed as in a still picture.
#[must_use]
pub fn place(viewport: &Viewport, style: &Style, labels: &[Label], memory: &mut Memory, dt_s: f64) -> Frame {
    let dt_s = if dt_s.is_finite() { dt_s.max(0.0) } else { 0.0 };
    let fresh = Board::new(viewport, style, labels);
    let moved = memory.seen.as_ref().is_none_or(|seen| !same(&seen.2, labels));
    let travel = memory.seen.as_ref().map(|seen| travel(&seen.2, labels));
    let known = memory.seen.as_ref().is_some_and(|seen| seen.0 == viewport.size && seen.1 == *style);
    if !known || travel.is_some_and(|px| px > CUT) {
        begin(&fresh, viewport, style, labels, memory);
    } else if moved {
        memory.turned += memory.seen.as_ref().map_or(0.0, |seen| turn(&seen.2, labels));
    }
    if moved {
        memory.still_s = 0.0;
        memory.clearing = false;
        memory.free_strides(style);
    } else {
        rest(&fresh, viewport, style, labels, memory, dt_s);
    }
    memory.seen = Some((viewport.size, *style, labels.to_vec()));
    let mut board = memory.board.unwrap_or(fresh);
    let reach = style.speed * dt_s;
    follow_edges(&fresh, &mut board, memory.edge_from, style, reach);
    memory.board = Some(board);
    let (kept, left_out) = sorted_out(&board, viewport, style, labels);
    let kept: BTreeSet<u64> = kept.into_iter().map(|n| labels[n].id).collect();
    update_tags(memory, labels, &kept);
    fade(memory, style, dt_s);
    wish(memory, &board, style);
    for column in 0..2 {
        memory.advance(&board, style, column, reach);
    }
    let busy = memory.clearing || memory.tags.values().any(matters);
    memory.rested_s = if busy { 0.0 } else { memory.rested_s + dt_s };
    let round = !busy && memory.rested_s >= style.rest_s;
    grant(memory, &board, style, round);
    if round {
        exchange(memory, &board, style);
    }
    frame(memory, &board, style, labels, left_out)
}

/// Whether two frames show the same labels; of points that are none, bit by bit.
fn same(before: &[Label], after: &[Label]) -> bool {
    let bits =
        |label: &Label| [label.anchor.x, label.anchor.y, label.size.x, label.size.y, label.priority].map(f64::to_bits);
    before.len() == after.len()
        && before.iter().zip(after).all(|(a, b)| a.id == b.id && a.visible == b.visible && bits(a) == bits(b))
}

/// Whether a label is changing places.
fn matters(tag: &Tag) -> bool {
    matches!(tag.stage, Stage::Crossing | Stage::Exchanging(_)) || (tag.arriving && tag.opacity < 1.0)
}

/// How far points went between two frames, on average, px.
fn travel(before: &[Label], after: &[Label]) -> f64 {
    let old: BTreeMap<u64, DVec2> = before.iter().map(|label| (label.id, label.anchor)).collect();
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for label in after {
        if let Some(from) = old.get(&label.id).filter(|from| from.is_finite() && label.anchor.is_finite()) {
            sum += from.distance(label.anchor);
            count += 1.0;
        }
    }
    sum / count.max(1.0)
}

/// By how much the scene turned between two frames, rad, about.
///
/// Of the affine map from (x, y, depth) to their changes, W, a turn by w has tr W² = −2 w², whatever the units and the axis. Where
/// points do not tell the map (few of them, or flat), it is how far they went as a share of how far they are apart.
fn turn(before: &[Label], after: &[Label]) -> f64 {
    let old: BTreeMap<u64, &Label> = before.iter().map(|label| (label.id, label)).collect();
    let point = |label: &Label| label.anchor.extend(label.depth);
    let ways: Vec<(DVec3, DVec3)> = after
        .iter()
        .filter_map(|label| Some((point(old.get(&label.id)?), point(label))))
        .filter(|(from, to)| from.is_finite() && to.is_finite())
        .collect();
    let count = ways.len().max(1) as f64;
    let middle = ways.iter().map(|way| way.0 + way.1).sum::<DVec3>() / (2.0 * count);
    let drift = ways.iter().map(|way| way.1 - way.0).sum::<DVec3>() / count;
    let (mut spread, mut change) = (DMat3::ZERO, DMat3::ZERO);
    let (mut gone, mut off) = (DVec2::ZERO, DVec2::splat(count));
    for (from, to) in ways {
        // Halfway between the two frames, where the changes belong.
        let at = (from + to) / 2.0 - middle;
        spread += outer(at, at);
        change += outer(to - from - drift, at);
        gone += (to - from).truncate().abs();
        off += at.truncate().abs();
    }
    let diagonal = DVec3::new(spread.x_axis.x, spread.y_axis.y, spread.z_axis.z);
    if spread.determinant() > 1e-3 * diagonal.element_product() {
        let map = change * spread.inverse();
        let square = map * map;
        return (-(square.x_axis.x + square.y_axis.y + square.z_axis.z) / 2.0).max(0.0).sqrt();
    }
    (gone / off).max_element()
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Places all labels as in a still picture; if some stood already they fade in.
fn begin(fresh: &Board, viewport: &Viewport, style: &Style, labels: &[Label], memory: &mut Memory) {
    let arriving = memory.seen.is_some();
    let opacity = if arriving { 0.0 } else { 1.0 };
    let turned = memory.turned;
    *memory =
        Memory { board: Some(*fresh), edge_from: fresh.edge, turned, seen: memory.seen.take(), ..Memory::default() };
    let arrangement = arrange(fresh, viewport, style, labels);
    for (column, stands) in arrangement.columns.iter().enumerate() {
        for &(n, y) in stands {
            let label = labels[n];
            let stand = Stand { y, low: y, high: y, height: label.size.y };
            memory.columns[column].push(Entry { id: label.id, kind: Kind::Shown, stand });
            memory.tags.insert(
                label.id,
                Tag { label, opacity, stage: Stage::Shown, arriving, kept: true, changed: Vec::new() },
            );
        }
    }
}

/// A scene that has been still for long enough: labels may go another stride, and are placed anew if they would be much better off.
fn rest(fresh: &Board, viewport: &Viewport, style: &Style, labels: &[Label], memory: &mut Memory, dt_s: f64) {
    let before_s = memory.still_s;
    memory.still_s += dt_s;
    if memory.clearing && memory.tags.values().all(|tag| tag.opacity <= 0.0) {
        begin(fresh, viewport, style, labels, memory);
        memory.still_s = style.still_s;
    } else if before_s < style.still_s && memory.still_s >= style.still_s {
        memory.free_strides(style);
        let arrangement = arrange(fresh, viewport, style, labels);
        let ideal = [0, 1].map(|column| {
            let stands = arrangement.columns[column].iter();
            ends(fresh, column, stands.map(|&(n, y)| (labels[n].anchor, y)))
        });
        let Some(board) = memory.board else { return };
        let actual = [memory.ends(&board, 0).1, memory.ends(&board, 1).1];
        let [best, held] = [ideal, actual].map(|both| {
            let mean = (both[0].len() + both[1].len()).max(1) as f64;
            route_both([&both[0], &both[1]], style.clearance)
                .iter()
                .map(|leaders| burden(leaders, style.bend))
                .sum::<f64>()
                / mean
        });
        memory.clearing = best < TIDIER * held;
    }
}

/// The columns' near edges follow the outline, lazily.
fn follow_edges(fresh: &Board, board: &mut Board, from: [f64; 2], style: &Style, reach: f64) {
    for (column, from) in from.into_iter().enumerate() {
        let held = board.edge[column];
        let wanted = held.max(fresh.edge[column]).min(fresh.edge[column] + LAZY_EDGE);
        let near = wanted.clamp(held - reach, held + reach);
        board.edge[column] = near.max(from - style.stride.x).min(from + style.stride.x).min(fresh.most[column]);
    }
    (board.middle, board.half, board.most) = (fresh.middle, fresh.half, fresh.most);
}

/// Takes in where points are now and which labels may have a place.
fn update_tags(memory: &mut Memory, labels: &[Label], kept: &BTreeSet<u64>) {
    let given: BTreeMap<u64, &Label> = labels.iter().map(|label| (label.id, label)).collect();
    let gone: Vec<u64> = memory.tags.keys().filter(|id| !given.contains_key(id)).copied().collect();
    for id in gone {
        memory.tags.remove(&id);
        memory.columns.iter_mut().for_each(|column| column.retain(|entry| entry.id != id));
    }
    for (id, label) in given {
        let fresh =
            Tag { label: *label, opacity: 0.0, stage: Stage::Absent, arriving: false, kept: true, changed: Vec::new() };
        let tag = memory.tags.entry(id).or_insert(fresh);
        let (anchor, size) = (tag.label.anchor, tag.label.size);
        tag.label = *label;
        if !tag.label.anchor.is_finite() {
            tag.label.anchor = anchor;
        }
        let stands = tag.stage != Stage::Absent;
        if stands {
            // A text that changes while it stands could run into its neighbours: it comes back with its new size.
            tag.label.size = size;
        }
        let keep = kept.contains(&id) && (!stands || size == label.size);
        tag.kept = keep;
        tag.stage = match tag.stage {
            Stage::Leaving if keep => Stage::Shown,
            Stage::Shown | Stage::Crossing | Stage::Exchanging(_) if !keep => Stage::Leaving,
            same => same,
        };
        let (leaves, absent) = (tag.stage == Stage::Leaving, tag.stage == Stage::Absent);
        if leaves || (absent && !keep) {
            memory.drop_entries(id, Kind::Wished);
            memory.drop_entries(id, Kind::Held);
        }
    }
    let broken: Vec<u64> = memory
        .tags
        .iter()
        .filter(|(id, tag)| match tag.stage {
            Stage::Exchanging(other) => memory.tags.get(&other).is_none_or(|o| o.stage != Stage::Exchanging(**id)),
            _ => false,
        })
        .map(|(id, _)| *id)
        .collect();
    for id in broken {
        memory.tags.entry(id).and_modify(|tag| tag.stage = Stage::Shown);
    }
}

/// A label has changed places and fades in.
fn arrive(tag: &mut Tag, turned: f64) {
    (tag.stage, tag.arriving) = (Stage::Shown, true);
    if let Some(last) = tag.changed.last_mut() {
        *last = turned;
    }
}

/// Opacities, and what happens when a label has faded out.
fn fade(memory: &mut Memory, style: &Style, dt_s: f64) {
    let part = |whole_s: f64| if whole_s > 0.0 { dt_s / whole_s } else { 1.0 };
    let (quick, slow) = (part(style.fade_s), part(style.hide_s));
    let ids: Vec<u64> = memory.tags.keys().copied().collect();
    for id in ids {
        let Some(tag) = memory.tags.get_mut(&id) else { continue };
        let hides = tag.stage == Stage::Leaving || (tag.stage == Stage::Shown && !tag.arriving && !memory.clearing);
        let share = if hides { slow } else { quick };
        match tag.stage {
            Stage::Absent => tag.opacity = 0.0,
            Stage::Shown if memory.clearing => tag.opacity = (tag.opacity - share).max(0.0),
            Stage::Shown => {
                tag.opacity = (tag.opacity + share).min(1.0);
                tag.arriving &= tag.opacity < 1.0;
            }
            Stage::Leaving | Stage::Crossing | Stage::Exchanging(_) => tag.opacity = (tag.opacity - share).max(0.0),
        }
        if tag.opacity > 0.0 {
            continue;
        }
        let stage = tag.stage;
        match stage {
            Stage::Leaving => {
                tag.stage = Stage::Absent;
                memory.drop_entries(id, Kind::Shown);
            }
            Stage::Crossing => {
                arrive(tag, memory.turned);
                memory.drop_entries(id, Kind::Shown);
                if let Some((column, at)) = memory.entry(id, Kind::Held) {
                    memory.columns[column][at].kind = Kind::Shown;
                }
            }
            Stage::Exchanging(other) if memory.tags.get(&other).is_some_and(|tag| tag.opacity <= 0.0) => {
                swap(memory, id, other);
                for id in [id, other] {
                    let turned = memory.turned;
                    memory.tags.entry(id).and_modify(|tag| arrive(tag, turned));
                }
            }
            _ => {}
        }
    }
}

/// What the frame shows.
fn frame(memory: &Memory, board: &Board, style: &Style, labels: &[Label], mut left_out: Vec<(usize, Reason)>) -> Frame {
    let mut placed = Vec::new();
    let both = [memory.ends(board, 0), memory.ends(board, 1)];
    let leaders = route_both([&both[0].1, &both[1].1], style.clearance);
    for (column, ((ids, ends), leaders)) in both.iter().zip(leaders).enumerate() {
        for ((id, ends), leader) in ids.iter().zip(ends).zip(leaders) {
            let Some(tag) = memory.tags.get(id) else { continue };
            placed.push(Placed {
                id: *id,
                rect: board.rect(column, ends.port.y, tag.label.size),
                side: Board::side(column),
                leader,
                opacity: tag.opacity,
                settled: tag.stage == Stage::Shown && tag.opacity >= 1.0 && !memory.clearing,
            });
        }
    }
    placed.sort_by_key(|label| label.id);
    let absent = |n: usize| memory.tags.get(&labels[n].id).is_some_and(|tag| tag.stage == Stage::Absent);
    let unplaced: BTreeSet<usize> = left_out.iter().map(|&(n, _)| n).collect();
    left_out.extend(
        (0..labels.len())
            .filter(|&n| labels[n].visible && absent(n) && !unplaced.contains(&n))
            .map(|n| (n, Reason::Waiting)),
    );
    left_out.sort_by(|a, b| lowest_first(&labels[a.0], &labels[b.0]));
    let settled = !memory.clearing && !memory.tags.values().any(matters);
    Frame {
        labels: placed,
        left_out: left_out.into_iter().map(|(n, reason)| (labels[n].id, reason)).collect(),
        settled,
    }
}
