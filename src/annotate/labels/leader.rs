//! Leaders that never cross, whatever the order of the labels in their columns.
//!
//! A leader runs from its anchor to its label's port, always onward in x. All labels of both columns have one order from top to
//! bottom. At the x of every anchor that a leader passes it goes by on the side on which its label lies from that anchor's label,
//! with a clearance that grows with the number of leaders in between; among all such ways it is the shortest: a taut string through
//! gates. Of two taut strings through gates that are ordered, neither crosses the other, for where they did the two could change
//! pieces and be shortened. So an order can be kept while points pass each other: a leader bends round a point where a straight one
//! would cross. Owns nothing. Source: boundary labelling (Bekos et al. 2007); the funnel algorithm (Lee and Preparata 1984).

use glam::DVec2;

/// Two anchors whose x is nearer than this are set this far apart, px: a leader has to pass one after the other.
const APART: f64 = 1e-3;

/// One end and the other of a leader, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// The labelled point.
    pub anchor: DVec2,
    /// Middle of the label's near edge; all of a column have the same x, left or right of all anchors.
    pub port: DVec2,
}

/// A vertical line that leaders cross above or below its owner's anchor.
struct Gate {
    x: f64,
    y: f64,
    owner: usize,
    /// `before[i]`: leaders of ranks below i that go through here.
    before: Vec<usize>,
}

/// The leaders of all labels, given in one order from top to bottom in which those of each column are in order of their ports.
///
/// Each runs from its anchor (x off by at most a thousandth of a pixel for each anchor that shares it) to its port. An anchor that
/// lies less than a pixel before its port, or beyond, is drawn back before it. `clearance` is the least distance in y between a
/// leader and a passed anchor, or the next leader there, px.
#[must_use]
pub fn route(order: &[Ends], clearance: f64) -> Vec<Vec<DVec2>> {
    let rightward = rightward(order);
    let starts = starts(order);
    let mut gates: Vec<Gate> = (0..order.len())
        .map(|owner| Gate { x: starts[owner], y: order[owner].anchor.y, owner, before: Vec::new() })
        .collect();
    gates.sort_by(|a, b| a.x.total_cmp(&b.x));
    for gate in &mut gates {
        let mut passing = 0;
        gate.before = (0..order.len())
            .map(|rank| {
                let before = passing;
                let passes = if rightward[rank] { starts[rank] < gate.x } else { starts[rank] > gate.x };
                passing += usize::from(passes);
                before
            })
            .collect();
    }
    (0..order.len())
        .map(|rank| {
            let start = DVec2::new(starts[rank], order[rank].anchor.y);
            if rightward[rank] {
                let first = gates.partition_point(|gate| gate.x <= start.x);
                taut(1.0, start, order[rank].port, gates[first..].iter().map(|gate| door(gate, rank, clearance)))
            } else {
                let last = gates.partition_point(|gate| gate.x < start.x);
                taut(-1.0, start, order[rank].port, gates[..last].iter().rev().map(|gate| door(gate, rank, clearance)))
            }
        })
        .collect()
}

/// Which leaders go to the right: their port is the farther right of the two columns' or, in one column, right of the anchors.
fn rightward(order: &[Ends]) -> Vec<bool> {
    let mean = order.iter().map(|ends| ends.anchor.x).sum::<f64>() / order.len().max(1) as f64;
    order.iter().map(|ends| ends.port.x > mean).collect()
}

/// Where leaders begin: the anchors' x, before both columns, no two the same.
fn starts(order: &[Ends]) -> Vec<f64> {
    let rightward = rightward(order);
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (ends, right) in order.iter().zip(rightward) {
        if right {
            high = high.min(ends.port.x - 1.0);
        } else {
            low = low.max(ends.port.x + 1.0);
        }
    }
    let mut starts: Vec<f64> = order.iter().map(|ends| ends.anchor.x.max(low).min(high)).collect();
    let mut across: Vec<usize> = (0..order.len()).collect();
    across.sort_by(|&a, &b| starts[a].total_cmp(&starts[b]).then(a.cmp(&b)));
    for pair in across.windows(2).rev() {
        starts[pair[0]] = starts[pair[0]].min(starts[pair[1]] - APART);
    }
    starts
}

/// A gate's x and the span of y that is open to a leader.
fn door(gate: &Gate, rank: usize, clearance: f64) -> (f64, f64, f64) {
    if rank < gate.owner {
        let between = (gate.before[gate.owner] - gate.before[rank]) as f64;
        (gate.x, f64::NEG_INFINITY, gate.y - clearance * between)
    } else {
        let between = (gate.before[rank] - gate.before[gate.owner] + 1) as f64;
        (gate.x, gate.y + clearance * between, f64::INFINITY)
    }
}

/// The shortest way through doors, toward +x (`way` 1) or −x (−1).
fn taut(way: f64, start: DVec2, end: DVec2, doors: impl Iterator<Item = (f64, f64, f64)>) -> Vec<DVec2> {
    let mut doors: Vec<(f64, f64, f64)> = doors.collect();
    doors.push((end.x, end.y, end.y));
    let mut leader = vec![start];
    let (mut apex, mut next) = (start, 0);
    'leg: loop {
        // The slopes that all doors so far leave open, and the door that sets each bound.
        let (mut least, mut most) = ((f64::NEG_INFINITY, next), (f64::INFINITY, next));
        for (n, &(x, low, high)) in doors.iter().enumerate().skip(next) {
            let run = way * (x - apex.x);
            let (to_low, to_high) = ((low - apex.y) / run, (high - apex.y) / run);
            let corner = if to_high < least.0 {
                Some((least.1, doors[least.1].1))
            } else if to_low > most.0 {
                Some((most.1, doors[most.1].2))
            } else {
                None
            };
            if let Some((door, y)) = corner {
                apex = DVec2::new(doors[door].0, y);
                leader.push(apex);
                next = door + 1;
                continue 'leg;
            }
            if to_low > least.0 {
                least = (to_low, n);
            }
            if to_high < most.0 {
                most = (to_high, n);
            }
        }
        leader.push(end);
        return leader;
    }
}

/// The leaders of a left and a right column, each given from top to bottom.
///
/// Where a leader to the left and one to the right pass each other, the one goes above whose straight line asks for less of a bend.
#[must_use]
pub fn route_both(columns: [&[Ends]; 2], clearance: f64) -> [Vec<Vec<DVec2>>; 2] {
    let merged = merge(columns, clearance);
    let order: Vec<Ends> = merged.iter().map(|&(column, n)| columns[column][n]).collect();
    let mut leaders = [vec![Vec::new(); columns[0].len()], vec![Vec::new(); columns[1].len()]];
    for ((column, n), leader) in merged.into_iter().zip(route(&order, clearance)) {
        leaders[column][n] = leader;
    }
    leaders
}

/// One order of both columns' labels, as (column, index), that keeps each column's.
fn merge(columns: [&[Ends]; 2], clearance: f64) -> Vec<(usize, usize)> {
    let [left, right] = columns;
    let rows = right.len() + 1;
    // ahead[i][q]: bends if the i-th left label comes after q right ones.
    let ahead: Vec<Vec<f64>> = left
        .iter()
        .map(|a| {
            let pairs: Vec<(f64, f64)> = right.iter().map(|b| bends(a, b, clearance)).collect();
            let mut cost: f64 = pairs.iter().map(|pair| pair.0).sum();
            let mut costs = vec![cost];
            for pair in pairs {
                cost += pair.1 - pair.0;
                costs.push(cost);
            }
            costs
        })
        .collect();
    // best[q]: least sum for the left labels so far, the last of them after q right ones.
    let mut best = vec![0.0; rows];
    let mut from: Vec<Vec<usize>> = Vec::with_capacity(left.len());
    for costs in &ahead {
        let (mut held, mut at, mut origins) = (f64::INFINITY, 0, Vec::with_capacity(rows));
        for (q, &sum) in best.iter().enumerate() {
            if sum < held {
                (held, at) = (sum, q);
            }
            origins.push(at);
        }
        best = origins.iter().zip(costs).map(|(&origin, cost)| best[origin] + cost).collect();
        from.push(origins);
    }
    let mut places = vec![0; left.len()];
    let mut at = (0..rows).min_by(|&a, &b| best[a].total_cmp(&best[b])).unwrap_or(0);
    for n in (0..left.len()).rev() {
        places[n] = at;
        at = from[n][at];
    }
    let mut merged = Vec::with_capacity(left.len() + right.len());
    let mut next = 0;
    for (n, place) in places.into_iter().enumerate() {
        merged.extend((next..place).map(|m| (1, m)));
        next = next.max(place);
        merged.push((0, n));
    }
    merged.extend((next..right.len()).map(|m| (1, m)));
    merged
}

/// How far a left leader and a right one have to bend if the left one goes above, and if it goes below, px.
fn bends(left: &Ends, right: &Ends, clearance: f64) -> (f64, f64) {
    if left.anchor.x <= right.anchor.x {
        return (0.0, 0.0);
    }
    let at = |ends: &Ends, x: f64| {
        let share = (x - ends.anchor.x) / (ends.port.x - ends.anchor.x);
        ends.anchor.y + (ends.port.y - ends.anchor.y) * share.clamp(0.0, 1.0)
    };
    let over = (right.anchor.y - at(left, right.anchor.x), at(right, left.anchor.x) - left.anchor.y);
    let need = |gap: f64| (clearance - gap).max(0.0);
    (need(over.0) + need(over.1), need(-over.0) + need(-over.1))
}

/// Length of a leader, px.
#[must_use]
pub fn length(leader: &[DVec2]) -> f64 {
    leader.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// How bad leaders look, in px: their lengths, and `bend` px for every right angle that they turn through.
#[must_use]
pub fn burden(leaders: &[Vec<DVec2>], bend: f64) -> f64 {
    let mut sum = 0.0;
    for leader in leaders {
        let mut before: Option<f64> = None;
        for pair in leader.windows(2) {
            let way = pair[1] - pair[0];
            let angle = way.y.atan2(way.x.abs());
            sum += way.length() + before.map_or(0.0, |held| bend * (angle - held).abs() / std::f64::consts::FRAC_PI_2);
            before = Some(angle);
        }
    }
    sum
}
