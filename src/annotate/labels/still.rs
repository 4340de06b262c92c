//! Labels in one still picture.
//!
//! Each point's label goes to the side on which the point lies, the ones nearest to the middle to the other where a column is full.
//! A column starts in the order of its points from top to bottom; then neighbours change places as long as that makes the leaders
//! shorter and straighter. Owns nothing and remembers nothing. Source: boundary labelling (Bekos et al. 2007).

use crate::annotate::labels::board::{Board, lowest_first, sorted_out};
use crate::annotate::labels::column::{Wish, spread};
use crate::annotate::labels::leader::{Ends, burden, route, route_both};
use crate::annotate::labels::types::{Frame, Label, Placed, Reason, Style, Viewport};
use glam::DVec2;

/// Rounds of exchanges in a column; each shortens the leaders, so this is only a guard.
const ROUNDS: usize = 40;

/// What [`arrange`] found.
pub(crate) struct Arrangement {
    /// Index of each label and the y of its middle, from top to bottom, left and right.
    pub columns: [Vec<(usize, f64)>; 2],
    /// Indices left out, lowest priority first.
    pub left_out: Vec<(usize, Reason)>,
}

/// Places labels in one picture, without memory. The same input gives the same picture.
///
/// Visible labels that find no room, or whose point is out of reach, are listed in `left_out`.
#[must_use]
pub fn place_still(viewport: &Viewport, style: &Style, labels: &[Label]) -> Frame {
    let board = Board::new(viewport, style, labels);
    let arrangement = arrange(&board, viewport, style, labels);
    let mut placed = Vec::new();
    let both = [0, 1]
        .map(|column| ends(&board, column, arrangement.columns[column].iter().map(|&(n, y)| (labels[n].anchor, y))));
    let leaders = route_both([&both[0], &both[1]], style.clearance);
    for (column, (stands, leaders)) in arrangement.columns.iter().zip(leaders).enumerate() {
        for (&(n, y), leader) in stands.iter().zip(leaders) {
            placed.push(Placed {
                id: labels[n].id,
                rect: board.rect(column, y, labels[n].size),
                side: Board::side(column),
                leader,
                opacity: 1.0,
                settled: true,
            });
        }
    }
    placed.sort_by_key(|label| label.id);
    let left_out = arrangement.left_out.iter().map(|&(n, reason)| (labels[n].id, reason)).collect();
    Frame { labels: placed, left_out, settled: true }
}

/// The ends of a column's leaders, from anchors and heights.
pub(crate) fn ends(board: &Board, column: usize, stands: impl Iterator<Item = (DVec2, f64)>) -> Vec<Ends> {
    stands.map(|(anchor, y)| Ends { anchor, port: board.port(column, y) }).collect()
}

/// Sides, orders and heights for one picture.
pub(crate) fn arrange(board: &Board, viewport: &Viewport, style: &Style, labels: &[Label]) -> Arrangement {
    let (mut kept, mut left_out) = sorted_out(board, viewport, style, labels);
    let height = board.bottom - board.top + style.gap;
    let sides = loop {
        if let Some(sides) = split(board, style, labels, &kept, height) {
            break sides;
        }
        // Kept ones come in order of priority, so the last is the next to go.
        match kept.pop() {
            Some(last) => left_out.push((last, Reason::NoRoom)),
            None => break [Vec::new(), Vec::new()],
        }
    };
    let mut column = 0;
    let columns = sides.map(|mut side| {
        side.sort_by(|&a, &b| labels[a].anchor.y.total_cmp(&labels[b].anchor.y).then(labels[a].id.cmp(&labels[b].id)));
        let stands = improved(board, column, style, labels, side);
        column += 1;
        stands
    });
    left_out.sort_by(|a, b| lowest_first(&labels[a.0], &labels[b.0]));
    Arrangement { columns, left_out }
}

/// Left and right labels: split at the object's middle, or as near to it as both columns' heights allow.
fn split(board: &Board, style: &Style, labels: &[Label], kept: &[usize], height: f64) -> Option<[Vec<usize>; 2]> {
    let mut across = kept.to_vec();
    across.sort_by(|&a, &b| labels[a].anchor.x.total_cmp(&labels[b].anchor.x).then(labels[a].id.cmp(&labels[b].id)));
    let needs = |part: &[usize]| part.iter().map(|&n| labels[n].size.y + style.gap).sum::<f64>();
    let natural = across.partition_point(|&n| labels[n].anchor.x < board.middle);
    let mut cuts: Vec<usize> = (0..=across.len()).collect();
    cuts.sort_by_key(|cut| cut.abs_diff(natural));
    let cut = cuts.into_iter().find(|&cut| needs(&across[..cut]) <= height && needs(&across[cut..]) <= height)?;
    let right = across.split_off(cut);
    Some([across, right])
}

/// The column's labels in the order that a local search finds best, with their heights.
fn improved(board: &Board, column: usize, style: &Style, labels: &[Label], mut order: Vec<usize>) -> Vec<(usize, f64)> {
    let laid = |order: &[usize]| -> Vec<f64> {
        let wishes: Vec<Wish> =
            order.iter().map(|&n| Wish { y: labels[n].anchor.y, height: labels[n].size.y }).collect();
        spread(&wishes, style.gap, style.roomy, board.top, board.bottom).unwrap_or_default()
    };
    let weigh = |order: &[usize]| -> f64 {
        let stands = order.iter().zip(laid(order)).map(|(&n, y)| (labels[n].anchor, y));
        burden(&route(&ends(board, column, stands), style.clearance), style.bend)
    };
    let mut held = weigh(&order);
    for _ in 0..ROUNDS {
        let before = held;
        for n in 1..order.len() {
            order.swap(n - 1, n);
            let tried = weigh(&order);
            if tried < held - 1e-6 {
                held = tried;
            } else {
                order.swap(n - 1, n);
            }
        }
        if held >= before {
            break;
        }
    }
    let heights = laid(&order);
    order.into_iter().zip(heights).collect()
}
