//! Bricks of level 0 that are to be looked at again: some, or all.

use std::collections::BTreeSet;

/// See the module's head. `None`: all.
#[derive(Debug)]
pub(super) struct Marks(Option<BTreeSet<usize>>);

impl Marks {
    /// All bricks.
    pub(super) fn all() -> Self {
        Self(None)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.as_ref().is_some_and(BTreeSet::is_empty)
    }

    pub(super) fn insert(&mut self, brick: usize) {
        if let Some(some) = &mut self.0 {
            some.insert(brick);
        }
    }

    pub(super) fn extend(&mut self, bricks: impl IntoIterator<Item = usize>) {
        if let Some(some) = &mut self.0 {
            some.extend(bricks);
        }
    }

    /// The marked bricks, in order, of `count` that there are; afterwards none is marked.
    pub(super) fn take(&mut self, count: usize) -> Vec<usize> {
        match self.0.replace(BTreeSet::new()) {
            Some(some) => some.into_iter().collect(),
            None => (0..count).collect(),
        }
    }
}
