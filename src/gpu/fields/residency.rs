//! Which bricks to hold: a cut through the levels that covers every needed brick of level 0 with the slots there are.
//!
//! Pure: knows no device. It is asked for only if the needed bricks do not all fit at level 0. The cut starts at the coarsest
//! level, which is one brick, and the most urgent brick is refined first, so that nothing is ever missing. The
//! cut depends on nothing but its arguments: a picture at rest is stable.

use crate::volume::{BrickKey, Field};
use std::collections::{BinaryHeap, HashMap, HashSet};

/// What is asked of a field whose needed bricks do not all fit.
pub(crate) struct Need<'a> {
    pub(crate) field: &'a Field,
    /// The needed bricks of level 0 with more than one value, in order.
    pub(crate) finest: &'a [BrickKey],
    /// How much each of them matters.
    pub(crate) urgency: &'a [f32],
    /// Slots there are.
    pub(crate) room: usize,
}

/// The answer: bricks with more than one value to be held, the most urgent first and every brick after those above it, and
/// bricks of one value that take part in the cut.
#[derive(Debug)]
pub(crate) struct Cut {
    pub(crate) held: Vec<BrickKey>,
    pub(crate) uniform: HashSet<BrickKey>,
}

/// Of equal urgency the finer level goes first, then the lower index: the order is total.
#[derive(PartialEq)]
struct Candidate {
    urgency: f32,
    key: BrickKey,
}
impl Eq for Candidate {}
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.urgency.total_cmp(&other.urgency).then_with(|| other.key.cmp(&self.key))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Chooses the cut.
pub(crate) fn choose(need: &Need<'_>) -> Cut {
    let field = need.field;
    // For every brick above a needed one: the greatest urgency below it, and its children.
    let mut most: HashMap<BrickKey, f32> = HashMap::new();
    let mut children: HashMap<BrickKey, Vec<BrickKey>> = HashMap::new();
    let mut layer: Vec<BrickKey> = need.finest.to_vec();
    most.extend(need.finest.iter().copied().zip(need.urgency.iter().copied()));
    for level in 1..field.level_count() {
        let mut parents = Vec::new();
        for key in layer {
            let parent = BrickKey { level, index: key.index.parent() };
            let below = most[&key];
            let family = children.entry(parent).or_insert_with(|| {
                parents.push(parent);
                Vec::new()
            });
            family.push(key);
            let best = most.entry(parent).or_insert(below);
            *best = best.max(below);
        }
        layer = parents;
    }
    let cost = |key: &BrickKey| usize::from(field.summary(*key).uniform.is_none());
    let mut chosen: HashSet<BrickKey> = HashSet::new();
    let mut order = Vec::new();
    let mut waiting: HashMap<BrickKey, usize> = HashMap::new();
    let mut queue = BinaryHeap::new();
    let mut used = 0;
    let enter = |key: BrickKey,
                 chosen: &mut HashSet<BrickKey>,
                 waiting: &mut HashMap<BrickKey, usize>,
                 queue: &mut BinaryHeap<Candidate>| {
        chosen.insert(key);
        let Some(family) = children.get(&key) else { return };
        waiting.insert(key, family.len());
        // What is gained is the difference between the parent's voxel and the child's, in pixels.
        let voxel = (1_u32 << key.level) as f32;
        queue.extend(family.iter().map(|&key| Candidate { urgency: most[&key] * voxel, key }));
    };
    for root in &layer {
        used += cost(root);
        order.push(*root);
        enter(*root, &mut chosen, &mut waiting, &mut queue);
    }
    while let Some(Candidate { key, .. }) = queue.pop() {
        let parent = BrickKey { level: key.level + 1, index: key.index.parent() };
        // The last of a family takes its parent's slot.
        let last = waiting[&parent] == 1;
        let freed = if last { cost(&parent) } else { 0 };
        if used + cost(&key) > need.room + freed {
            continue;
        }
        used = used + cost(&key) - freed;
        if last {
            chosen.remove(&parent);
        }
        waiting.entry(parent).and_modify(|n| *n -= 1);
        order.push(key);
        enter(key, &mut chosen, &mut waiting, &mut queue);
    }
    let (held, uniform) = order.into_iter().filter(|key| chosen.contains(key)).partition::<Vec<_>, _>(|k| cost(k) == 1);
    Cut { held, uniform: uniform.into_iter().collect() }
}
