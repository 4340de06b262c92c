//! What the placing of labels remembers from frame to frame.
//!
//! Two columns hold entries in order from top to bottom: labels that stand there, room held for one that is on its way, and wishes
//! for room that is not yet there. Beside them, for each label, its last point, its opacity and what it is doing. Owns these and
//! their bookkeeping; decides nothing.

use crate::annotate::labels::board::Board;
use crate::annotate::labels::column::{Stand, Wish, approach, spread};
use crate::annotate::labels::leader::Ends;
use crate::annotate::labels::types::{Label, Style};
use glam::DVec2;
use std::collections::BTreeMap;

/// What an entry of a column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Room wished for; neighbours make it as they may.
    Wished,
    /// Room held for a label that still fades on the other side.
    Held,
    /// A label stands here.
    Shown,
}

/// A place in a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    pub id: u64,
    pub kind: Kind,
    pub stand: Stand,
}

/// What a label is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// It has no place.
    Absent,
    /// It stands, or fades in where it stands.
    Shown,
    /// It fades out to be gone.
    Leaving,
    /// It fades out to appear in the other column.
    Crossing,
    /// It fades out to change places with this neighbour.
    Exchanging(u64),
}

/// What is known of one label.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tag {
    /// As last given, with the last anchor that was a point.
    pub label: Label,
    pub opacity: f64,
    pub stage: Stage,
    /// It is to have a place.
    pub kept: bool,
    /// It fades in after a change of places.
    pub arriving: bool,
    /// How far the scene had turned at each of its changes of places.
    pub changed: Vec<f64>,
}

/// Where labels were: the placing's state between frames. A new one remembers nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    pub(crate) board: Option<Board>,
    /// u of the edges when the scene last moved.
    pub(crate) edge_from: [f64; 2],
    pub(crate) columns: [Vec<Entry>; 2],
    pub(crate) tags: BTreeMap<u64, Tag>,
    /// What the scene was: size of the picture, style, and labels as given.
    pub(crate) seen: Option<(DVec2, Style, Vec<Label>)>,
    /// How far the scene has turned, rad, about.
    pub(crate) turned: f64,
    /// All labels fade out to be placed anew.
    pub(crate) clearing: bool,
    /// Time since labels last changed places, s.
    pub(crate) rested_s: f64,
    /// Time since the scene last moved, s.
    pub(crate) still_s: f64,
}

impl Memory {
    /// Column and index of a label's entry of this kind.
    pub(crate) fn entry(&self, id: u64, kind: Kind) -> Option<(usize, usize)> {
        (0..2).find_map(|column| {
            let at = self.columns[column].iter().position(|entry| entry.id == id && entry.kind == kind)?;
            Some((column, at))
        })
    }

    /// Takes a label's entries of this kind out.
    pub(crate) fn drop_entries(&mut self, id: u64, kind: Kind) {
        for column in &mut self.columns {
            column.retain(|entry| entry.id != id || entry.kind != kind);
        }
    }

    /// Ends of the leaders of a column's shown labels, in order, with their ids.
    pub(crate) fn ends(&self, board: &Board, column: usize) -> (Vec<u64>, Vec<Ends>) {
        let shown = self.columns[column].iter().filter(|entry| entry.kind == Kind::Shown);
        shown
            .filter_map(|entry| {
                let anchor = self.tags.get(&entry.id)?.label.anchor;
                Some((entry.id, Ends { anchor, port: board.port(column, entry.stand.y) }))
            })
            .unzip()
    }

    /// Every label may go a full stride from where it is.
    pub(crate) fn free_strides(&mut self, style: &Style) {
        for entry in self.columns.iter_mut().flatten() {
            (entry.stand.low, entry.stand.high) = (entry.stand.y - style.stride.y, entry.stand.y + style.stride.y);
        }
        if let Some(board) = &self.board {
            self.edge_from = board.edge;
        }
    }

    /// Moves a column's labels toward their points, as far as strides and `reach` px let them, and sets wishes where room is to be.
    ///
    /// Wishes for which the column has no height are dropped, the lowest priority first.
    pub(crate) fn advance(&mut self, board: &Board, style: &Style, column: usize, reach: f64) {
        let entries = &mut self.columns[column];
        let aims = loop {
            let wishes: Vec<Wish> = entries
                .iter()
                .map(|entry| Wish {
                    y: self.tags.get(&entry.id).map_or(entry.stand.y, |tag| tag.label.anchor.y),
                    height: entry.stand.height,
                })
                .collect();
            if let Some(aims) = spread(&wishes, style.gap, style.roomy, board.top, board.bottom) {
                break aims;
            }
            let rank = |entry: &Entry| self.tags.get(&entry.id).map_or(0.0, |tag| tag.label.priority);
            let wished = entries.iter().enumerate().filter(|(_, entry)| entry.kind == Kind::Wished);
            match wished.min_by(|a, b| rank(a.1).total_cmp(&rank(b.1)).then(b.1.id.cmp(&a.1.id))) {
                Some((at, _)) => {
                    entries.remove(at);
                }
                None => return,
            }
        };
        let real: Vec<usize> = (0..entries.len()).filter(|&n| entries[n].kind != Kind::Wished).collect();
        let mut stands: Vec<Stand> = real.iter().map(|&n| entries[n].stand).collect();
        approach(&mut stands, &real.iter().map(|&n| aims[n]).collect::<Vec<f64>>(), style.gap, reach);
        for (&n, stand) in real.iter().zip(stands) {
            entries[n].stand = stand;
        }
        for (entry, aim) in entries.iter_mut().zip(aims) {
            if entry.kind == Kind::Wished {
                entry.stand.y = aim;
            }
        }
    }

    /// The y between the standing neighbours of a column's entry at which it has room, nearest to its own, if it has any.
    pub(crate) fn room_at(&self, board: &Board, style: &Style, column: usize, at: usize) -> Option<f64> {
        let entries = &self.columns[column];
        let stand = entries[at].stand;
        let real = |entry: &&Entry| entry.kind != Kind::Wished;
        let above =
            entries[..at].iter().rev().find(real).map_or(board.top, |e| e.stand.y + e.stand.height / 2.0 + style.gap);
        let below =
            entries[at + 1..].iter().find(real).map_or(board.bottom, |e| e.stand.y - e.stand.height / 2.0 - style.gap);
        let (low, high) = (above + stand.height / 2.0, below - stand.height / 2.0);
        (low <= high).then(|| stand.y.max(low).min(high))
    }
}
