//! Heights of the labels in one column.
//!
//! The labels of a column keep their order; each wants to be as near as it can to its wish, and no two may come nearer than their
//! heights and a gap. That is isotonic regression after the gaps' sum is taken off, solved by pooling adjacent violators, so heights
//! change continuously with the wishes. Owns nothing; knows neither labels nor sides. Source: Ayer et al. 1955 (pool adjacent
//! violators).

/// One label of a column: where it wants its middle, and its height, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Wanted y of the middle, px.
    pub y: f64,
    /// Height, px, above 0.
    pub height: f64,
}

/// The heights of a column with this gap between neighbours, px.
fn filled(wishes: &[Wish], gap: f64) -> f64 {
    wishes.iter().map(|wish| wish.height + gap).sum::<f64>() - if wishes.is_empty() { 0.0 } else { gap }
}

/// Middles of the labels, px, in their order from top to bottom: the sum of squared distances from the wishes is the least that is
/// possible between `top` and `bottom` with `gap` between neighbours, or with `roomy` where all fit so (or as much as fits).
///
/// `None` if they do not fit with `gap`.
#[must_use]
pub fn spread(wishes: &[Wish], gap: f64, roomy: f64, top: f64, bottom: f64) -> Option<Vec<f64>> {
    let spare = bottom - top - filled(wishes, gap);
    if spare < 0.0 {
        return None;
    }
    let gaps = (wishes.len().max(2) - 1) as f64;
    let gap = (gap + spare / gaps).min(roomy.max(gap));
    // offsets[n]: where the n-th middle lies if the first one's top edge is at 0 and all touch.
    let mut offsets = Vec::with_capacity(wishes.len());
    let mut down = 0.0;
    for wish in wishes {
        offsets.push(down + wish.height / 2.0);
        down += wish.height + gap;
    }
    let (least, most) = (top, bottom - (down - gap).max(0.0));
    // (mean, count) of each pool.
    let mut pools: Vec<(f64, f64)> = Vec::with_capacity(wishes.len());
    for (wish, offset) in wishes.iter().zip(&offsets) {
        let mut pool = (wish.y - offset, 1.0);
        while let Some(&(mean, count)) = pools.last() {
            if mean <= pool.0 {
                break;
            }
            pool = ((mean * count + pool.0 * pool.1) / (count + pool.1), count + pool.1);
            pools.pop();
        }
        pools.push(pool);
    }
    let means =
        pools.iter().flat_map(|&(mean, count)| std::iter::repeat_n(mean.clamp(least, most.max(least)), count as usize));
    Some(means.zip(&offsets).map(|(mean, offset)| mean + offset).collect())
}

/// A label that stands in a column, and how far it may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// Middle, px.
    pub y: f64,
    /// Least middle until the scene moves again, px.
    pub low: f64,
    /// Greatest middle until the scene moves again, px.
    pub high: f64,
    /// Height, px.
    pub height: f64,
}

/// Moves labels toward their aims by at most `reach` px, none out of its own bounds, and none nearer to the next than `gap`.
///
/// `stands` are in order from top to bottom and apart by the gap, as are `aims`; then they are so afterwards.
pub fn approach(stands: &mut [Stand], aims: &[f64], gap: f64, reach: f64) {
    // Bounds that are apart as the labels are: clamping a legal column by them gives a legal one.
    for n in 1..stands.len() {
        let apart = (stands[n - 1].height + stands[n].height) / 2.0 + gap;
        stands[n].low = stands[n].low.max(stands[n - 1].low + apart).min(stands[n].y);
    }
    for n in (1..stands.len()).rev() {
        let apart = (stands[n - 1].height + stands[n].height) / 2.0 + gap;
        stands[n - 1].high = stands[n - 1].high.min(stands[n].high - apart).max(stands[n - 1].y);
    }
    for (stand, aim) in stands.iter_mut().zip(aims) {
        let near = aim.clamp(stand.y - reach, stand.y + reach);
        stand.y = near.max(stand.low).min(stand.high);
    }
}
