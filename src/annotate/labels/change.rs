//! When labels change places while the scene moves, and where they go.
//!
//! Three things change a label's place: it appears, its point goes to the other side of the object, or it and a neighbour change
//! places because their leaders get shorter and straighter by that. A label that needs new room wishes for it first; its neighbours
//! make it as they may, and it goes once the room is there. Owns these decisions; what is remembered is [`Memory`]'s, and when a
//! round of changes begins is the caller's to say.

use crate::annotate::labels::board::Board;
use crate::annotate::labels::column::Stand;
use crate::annotate::labels::leader::{Ends, burden, route};
use crate::annotate::labels::memory::{Entry, Kind, Memory, Stage, Tag};
use crate::annotate::labels::types::Style;
use std::collections::BTreeSet;

/// A quarter turn and what its estimate may be too great by, rad.
const QUARTER: f64 = std::f64::consts::FRAC_PI_2 * 1.15;

/// How far from its point a label looks for a place in the order, px.
const SEARCH: f64 = 90.0;

/// How often a label changed places in about the last quarter turn.
fn recent(tag: &Tag, turned: f64) -> usize {
    tag.changed.iter().filter(|at| turned - **at < QUARTER).count()
}

/// Notes a change of places, and forgets those that no longer count.
fn note(tag: &mut Tag, turned: f64) {
    tag.changed.retain(|at| turned - *at < QUARTER);
    tag.changed.push(turned);
}

/// Whether the scene has turned since a label's last change: it changes places at most once in a step.
fn rested(tag: &Tag, turned: f64) -> bool {
    tag.changed.last().is_none_or(|at| *at < turned)
}

/// Two neighbours change places within the room of both.
pub(crate) fn swap(memory: &mut Memory, a: u64, b: u64) {
    let (Some((column, at)), Some((other, to))) = (memory.entry(a, Kind::Shown), memory.entry(b, Kind::Shown)) else {
        return;
    };
    let (upper, lower) = (at.min(to), at.max(to));
    let entries = &mut memory.columns[column];
    if column != other || entries[upper + 1..lower].iter().any(|entry| entry.kind != Kind::Wished) {
        return;
    }
    let (above, below) = (entries[upper].stand, entries[lower].stand);
    let rises = above.y - above.height / 2.0 + below.height / 2.0;
    let sinks = below.y + below.height / 2.0 - above.height / 2.0;
    entries.swap(upper, lower);
    entries[upper].stand = Stand { y: rises, low: rises, high: rises, height: below.height };
    entries[lower].stand = Stand { y: sinks, low: sinks, high: sinks, height: above.height };
}

/// Wishes for room: of labels that have no place, and of those whose point has gone to the other side.
pub(crate) fn wish(memory: &mut Memory, board: &Board, style: &Style) {
    let band = style.dead_band * board.half;
    let ids: Vec<u64> = memory.tags.keys().copied().collect();
    for id in ids {
        let Some(tag) = memory.tags.get(&id).cloned() else { continue };
        let wished = memory.entry(id, Kind::Wished);
        match tag.stage {
            Stage::Absent if tag.kept => {
                let near = usize::from(board.toward(1, tag.label.anchor) >= 0.0);
                let stale = wished.is_some_and(|(column, _)| board.toward(1 - column, tag.label.anchor) > band);
                if stale {
                    memory.drop_entries(id, Kind::Wished);
                }
                if wished.is_none() || stale {
                    let column = if fits_in(memory, board, style, near, tag.label.size.y) { near } else { 1 - near };
                    insert(memory, board, style, column, &tag);
                }
            }
            Stage::Shown => {
                let Some((column, _)) = memory.entry(id, Kind::Shown) else { continue };
                let past = board.toward(1 - column, tag.label.anchor);
                if wished.is_none() && past > band && fits_in(memory, board, style, 1 - column, tag.label.size.y) {
                    insert(memory, board, style, 1 - column, &tag);
                } else if wished.is_some() && past < 0.0 {
                    memory.drop_entries(id, Kind::Wished);
                }
            }
            _ => {}
        }
    }
}

/// Whether a column has the height for one more label.
fn fits_in(memory: &Memory, board: &Board, style: &Style, column: usize, height: f64) -> bool {
    let used: f64 = memory.columns[column].iter().map(|entry| entry.stand.height + style.gap).sum();
    used + height <= board.bottom - board.top
}

/// Puts a wish into a column's order where leaders get least long.
fn insert(memory: &mut Memory, board: &Board, style: &Style, column: usize, tag: &Tag) {
    let y = tag.label.anchor.y;
    let (ids, ends) = memory.ends(board, column);
    let mut best: Option<(usize, f64)> = None;
    for rank in 0..=ends.len() {
        let above = rank.checked_sub(1).map_or(board.top, |n| ends[n].port.y);
        let below = ends.get(rank).map_or(board.bottom, |end| end.port.y);
        let at = if below - above < 2.0 * tag.label.size.y {
            f64::midpoint(above, below)
        } else {
            y.clamp(above + tag.label.size.y, below - tag.label.size.y)
        };
        let mut tried: Vec<Ends> = ends.clone();
        tried.insert(rank, Ends { anchor: tag.label.anchor, port: board.port(column, at) });
        let far = (at - y).abs();
        if far > SEARCH && best.is_some() {
            continue;
        }
        let weight = burden(&route(&tried, style.clearance), style.bend) + if far > SEARCH { 1e6 + far } else { 0.0 };
        if best.is_none_or(|(_, held)| weight < held) {
            best = Some((rank, weight));
        }
    }
    let rank = best.map_or(0, |(rank, _)| rank);
    let entries = &mut memory.columns[column];
    let at = ids
        .get(rank)
        .and_then(|next| entries.iter().position(|e| e.id == *next && e.kind == Kind::Shown))
        .unwrap_or(entries.len());
    let stand = Stand { y, low: y, high: y, height: tag.label.size.y };
    entries.insert(at, Entry { id: tag.label.id, kind: Kind::Wished, stand });
}

/// Gives room where it is: to labels without a place at once, to those that change sides in a round of changes.
pub(crate) fn grant(memory: &mut Memory, board: &Board, style: &Style, round: bool) {
    for column in 0..2 {
        for at in 0..memory.columns[column].len() {
            let entry = memory.columns[column][at];
            let Some(tag) = memory.tags.get(&entry.id).cloned().filter(|_| entry.kind == Kind::Wished) else {
                continue;
            };
            let crosses = tag.stage == Stage::Shown;
            if crosses && (!round || tag.opacity < 1.0 || !rested(&tag, memory.turned)) {
                continue;
            }
            let Some(y) = memory.room_at(board, style, column, at) else { continue };
            let kind = if crosses { Kind::Held } else { Kind::Shown };
            let stand = Stand { y, low: y, high: y, height: entry.stand.height };
            memory.columns[column][at] = Entry { id: entry.id, kind, stand };
            let turned = memory.turned;
            memory.tags.entry(entry.id).and_modify(|tag| {
                tag.stage = if crosses { Stage::Crossing } else { Stage::Shown };
                if crosses {
                    note(tag, turned);
                }
            });
        }
    }
}

/// Neighbours whose leaders get shorter and straighter by enough change places.
pub(crate) fn exchange(memory: &mut Memory, board: &Board, style: &Style) {
    for column in 0..2 {
        let (ids, ends) = memory.ends(board, column);
        let held = burden(&route(&ends, style.clearance), style.bend);
        let free = |id: &u64| {
            memory.tags.get(id).is_some_and(|tag| {
                let may = rested(tag, memory.turned) && recent(tag, memory.turned) + 1 < style.changes;
                may && tag.stage == Stage::Shown && tag.opacity >= 1.0
            }) && memory.entry(*id, Kind::Wished).is_none()
        };
        let next_to = |a: u64, b: u64| {
            let places = memory.entry(a, Kind::Shown).zip(memory.entry(b, Kind::Shown));
            places.is_some_and(|(a, b)| {
                memory.columns[column][a.1..b.1].iter().skip(1).all(|entry| entry.kind == Kind::Wished)
            })
        };
        let mut gains: Vec<(f64, usize)> = Vec::new();
        for n in 1..ids.len() {
            if free(&ids[n - 1]) && free(&ids[n]) && next_to(ids[n - 1], ids[n]) {
                let mut tried = ends.clone();
                (tried[n - 1].anchor, tried[n].anchor) = (ends[n].anchor, ends[n - 1].anchor);
                let gain = held - burden(&route(&tried, style.clearance), style.bend);
                if gain > style.worth {
                    gains.push((gain, n));
                }
            }
        }
        gains.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut taken = BTreeSet::new();
        for (_, n) in gains {
            if taken.contains(&(n - 1)) || taken.contains(&n) {
                continue;
            }
            taken.extend([n - 1, n]);
            let turned = memory.turned;
            for (id, other) in [(ids[n - 1], ids[n]), (ids[n], ids[n - 1])] {
                memory.tags.entry(id).and_modify(|tag| {
                    tag.stage = Stage::Exchanging(other);
                    note(tag, turned);
                });
            }
        }
    }
}
