//! Bricks of level 0 that are to be looked at again: some, or all.

use std::collections::BTreeSet;

/// Numbers of the bricks of level 0 that are to be looked at again; `None`: all of them.
#[derive(Clone, Debug)]
pub(crate) struct DirtyBricks(Option<BTreeSet<usize>>);

impl DirtyBricks {
    /// All bricks.
    pub(crate) fn all() -> Self {
        Self(None)
    }

    /// Whether not all are dirty.
    pub(crate) fn is_some(&self) -> bool {
        self.0.is_some()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.as_ref().is_some_and(BTreeSet::is_empty)
    }

    pub(crate) fn insert(&mut self, brick: usize) {
        if let Some(some) = &mut self.0 {
            some.insert(brick);
        }
    }

    pub(crate) fn extend(&mut self, bricks: impl IntoIterator<Item = usize>) {
        if let Some(some) = &mut self.0 {
            some.extend(bricks);
        }
    }

    /// The dirty bricks, in order, of `count` that there are; afterwards none is dirty.
    pub(crate) fn take(&mut self, count: usize) -> Vec<usize> {
        match self.0.replace(BTreeSet::new()) {
            Some(some) => some.into_iter().collect(),
            None => (0..count).collect(),
        }
    }
}
