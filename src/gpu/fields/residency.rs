//! Which bricks to hold: a cut through the levels that covers every needed brick of level 0 with the slots there are.
//!
//! Pure: knows no device. It is asked for only if the needed bricks do not all fit at level 0. The cut starts at each volume's
//! coarsest level, which is one brick, and the most urgent brick of all volumes is refined first, so that nothing is ever
//! missing and the room goes where it is needed. The cut depends on nothing but its arguments: a picture at rest is stable.

use crate::gpu::fields::slot_key::SlotKey;
use crate::volume::{Field, VolumeId};
use std::collections::{BinaryHeap, HashMap, HashSet};

/// What is asked of fields whose needed bricks do not all fit.
pub(crate) struct Need<'a, 'f> {
    pub(crate) field_of: &'a dyn Fn(VolumeId) -> Option<&'f Field>,
    /// The needed bricks of level 0 with more than one value, in order.
    pub(crate) finest: &'a [SlotKey],
    /// How much each of them matters.
    pub(crate) urgency: &'a [f32],
    /// Slots there are.
    pub(crate) room: usize,
}

impl Need<'_, '_> {
    fn cost(&self, key: &SlotKey) -> usize {
        let field = (self.field_of)(key.volume);
        usize::from(field.is_some_and(|field| field.summary(key.brick).uniform.is_none()))
    }

    fn is_coarsest(&self, key: SlotKey) -> bool {
        (self.field_of)(key.volume).is_none_or(|field| key.brick.level + 1 >= field.level_count())
    }
}

/// The answer: bricks with more than one value to be held, the most urgent first and every brick after those above it, and
/// bricks of one value that take part in the cut.
#[derive(Debug)]
pub(crate) struct LevelCut {
    pub(crate) held: Vec<SlotKey>,
    pub(crate) uniform: HashSet<SlotKey>,
}

/// Of equal urgency the finer level goes first, then the lower index, then the volume that came first: the order is total.
#[derive(PartialEq)]
struct Candidate {
    urgency: f32,
    key: SlotKey,
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
pub(crate) fn choose(need: &Need<'_, '_>) -> LevelCut {
    // For every brick above a needed one: the greatest urgency below it, and its children.
    let mut most: HashMap<SlotKey, f32> = HashMap::new();
    let mut children: HashMap<SlotKey, Vec<SlotKey>> = HashMap::new();
    let mut layer: Vec<SlotKey> = need.finest.to_vec();
    let mut roots: Vec<SlotKey> = Vec::new();
    most.extend(need.finest.iter().copied().zip(need.urgency.iter().copied()));
    while !layer.is_empty() {
        let mut parents = Vec::new();
        for key in layer {
            if need.is_coarsest(key) {
                roots.push(key);
                continue;
            }
            let parent = key.parent();
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
    let mut chosen: HashSet<SlotKey> = HashSet::new();
    let mut order = Vec::new();
    let mut waiting: HashMap<SlotKey, usize> = HashMap::new();
    let mut queue = BinaryHeap::new();
    let mut used = 0;
    let enter = |key: SlotKey,
                 chosen: &mut HashSet<SlotKey>,
                 waiting: &mut HashMap<SlotKey, usize>,
                 queue: &mut BinaryHeap<Candidate>| {
        chosen.insert(key);
        let Some(family) = children.get(&key) else { return };
        waiting.insert(key, family.len());
        // What is gained is the difference between the parent's voxel and the child's, in pixels.
        let voxel = (1_u32 << key.brick.level) as f32;
        queue.extend(family.iter().map(|&key| Candidate { urgency: most[&key] * voxel, key }));
    };
    for root in &roots {
        used += need.cost(root);
        order.push(*root);
        enter(*root, &mut chosen, &mut waiting, &mut queue);
    }
    while let Some(Candidate { key, .. }) = queue.pop() {
        let parent = key.parent();
        // The last of a family takes its parent's slot.
        let last = waiting[&parent] == 1;
        let freed = if last { need.cost(&parent) } else { 0 };
        if used + need.cost(&key) > need.room + freed {
            continue;
        }
        used = used + need.cost(&key) - freed;
        if last {
            chosen.remove(&parent);
        }
        waiting.entry(parent).and_modify(|n| *n -= 1);
        order.push(key);
        enter(key, &mut chosen, &mut waiting, &mut queue);
    }
    let chosen = order.into_iter().filter(|key| chosen.contains(key));
    let (held, uniform) = chosen.partition::<Vec<_>, _>(|key| need.cost(key) == 1);
    LevelCut { held, uniform: uniform.into_iter().collect() }
}
