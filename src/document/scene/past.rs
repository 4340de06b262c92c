//! The past of views and looks, apart from undo, so that undo moves no camera and brings back no window.
//!
//! Views and looks are walked each for itself or both by the order in which they changed. Owns what was seen before and what lies
//! ahead again; it is saved with the project, and the journal writes only what is new of it. A group of history is one change.
//! Knows no command and no disk.

use crate::document::scene::{Looks, Scene, Views};
use serde::{Deserialize, Serialize};

/// What `view.back` walks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PastOf {
    /// Cameras, slices, crosshair.
    Views,
    /// Transfer function, look, window, layers.
    Looks,
}

/// More are not kept: nobody walks back that far, and every save writes them.
const KEPT: usize = 128;

/// A change that can be taken back, or done again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Change<T> {
    /// When it was done, taken back or done again, counted over both kinds.
    number: u64,
    /// What the user did.
    name: String,
    /// What is seen once it is taken back, or done again.
    other: T,
}

/// The changes of one kind: `back` ends with the newest, `forward` with the one that was taken back last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Line<T> {
    back: Vec<Change<T>>,
    forward: Vec<Change<T>>,
}

impl<T> Default for Line<T> {
    fn default() -> Self {
        Self { back: Vec::new(), forward: Vec::new() }
    }
}

/// Earlier and later views and looks, each walked back and forth for itself or by the order of their changes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Past {
    #[serde(default)]
    views: Line<Views>,
    #[serde(default)]
    looks: Line<Looks>,
    #[serde(default)]
    changes: u64,
}

/// What the open group of history has changed so far; a drag is one change, however many commands it has.
#[derive(Debug, Default)]
pub(crate) struct PastGroup {
    views: Option<Begun<Views>>,
    looks: Option<Begun<Looks>>,
}

/// What a group's first change put aside.
#[derive(Debug)]
struct Begun<T> {
    forward: Vec<Change<T>>,
}

impl<T: Clone + PartialEq> Line<T> {
    fn push(&mut self, change: Change<T>, group: Option<&mut Option<Begun<T>>>) {
        match group {
            Some(Some(_)) => {
                // What was there first comes back, under the last change's name.
                if let Some(first) = self.back.last_mut() {
                    first.name = change.name;
                }
                return;
            }
            Some(begun) => *begun = Some(Begun { forward: std::mem::take(&mut self.forward) }),
            None => self.forward.clear(),
        }
        self.back.push(change);
        let over = self.back.len().saturating_sub(KEPT);
        self.back.drain(..over);
    }

    /// Exchanges what is seen with what was before (or comes after a `back`); answers the change's name.
    fn walk(&mut self, back: bool, number: u64, exchange: impl FnOnce(&mut T)) -> Option<String> {
        let (from, to) = if back { (&mut self.back, &mut self.forward) } else { (&mut self.forward, &mut self.back) };
        let mut change = from.pop()?;
        change.number = number;
        exchange(&mut change.other);
        let name = change.name.clone();
        to.push(change);
        Some(name)
    }

    fn next(&self, back: bool) -> Option<&Change<T>> {
        if back { self.back.last() } else { self.forward.last() }
    }

    /// Forgets the change of a group that ended where it began.
    fn unpush(&mut self, begun: Begun<T>) -> Option<T> {
        self.forward = begun.forward;
        self.back.pop().map(|change| change.other)
    }
}

impl Past {
    /// Nothing is behind and nothing ahead.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Notes a change of view; those of one group are one change.
    pub(crate) fn viewed(&mut self, name: &str, before: Views, now: &Views, group: Option<&mut PastGroup>) {
        if before != *now {
            self.changes = self.changes.saturating_add(1);
            let change = Change { number: self.changes, name: name.into(), other: before };
            self.views.push(change, group.map(|g| &mut g.views));
        }
    }

    /// Notes a change of looks; those of one group are one change.
    pub(crate) fn looked(&mut self, name: &str, before: Looks, group: Option<&mut PastGroup>) {
        self.changes = self.changes.saturating_add(1);
        let change = Change { number: self.changes, name: name.into(), other: before };
        self.looks.push(change, group.map(|g| &mut g.looks));
    }

    /// A group has ended; what is as it was before it is no change.
    pub(crate) fn group_closed(&mut self, group: PastGroup, scene: &Scene) {
        if let Some(begun) = group.views
            && self.views.back.last().is_some_and(|c| c.other == *scene.views)
        {
            self.views.unpush(begun);
        }
        if let Some(begun) = group.looks
            && self.looks.back.last().is_some_and(|c| c.other.are_of(scene))
        {
            self.looks.unpush(begun);
        }
    }

    /// A group is taken back: looks are as they were before it. Views stay, as undo leaves them.
    pub(crate) fn group_cancelled(&mut self, group: PastGroup, scene: &mut Scene) {
        if let Some(mut before) = group.looks.and_then(|begun| self.looks.unpush(begun)) {
            before.exchange(scene);
        }
    }

    /// Exchanges what is seen with what was before (or comes after a `back`); sizes in pixels stay. Answers what was walked and the
    /// change's name, `None` if there is none.
    pub(crate) fn walk(&mut self, scene: &mut Scene, of: Option<PastOf>, back: bool) -> Option<(PastOf, String)> {
        let of = self.which(of, back)?;
        self.changes = self.changes.saturating_add(1);
        let name = match of {
            PastOf::Views => self.views.walk(back, self.changes, |other| {
                let now: &mut Views = &mut scene.views;
                other.size = now.size;
                for (slice, now) in other.slices.iter_mut().zip(&now.slices) {
                    slice.size = now.size;
                }
                std::mem::swap(now, other);
            }),
            PastOf::Looks => self.looks.walk(back, self.changes, |other| other.exchange(scene)),
        };
        name.map(|name| (of, name))
    }

    /// The name of the change that would be walked.
    pub fn next(&self, of: Option<PastOf>, back: bool) -> Option<&str> {
        match self.which(of, back)? {
            PastOf::Views => self.views.next(back).map(|c| c.name.as_str()),
            PastOf::Looks => self.looks.next(back).map(|c| c.name.as_str()),
        }
    }

    /// Of two changes behind, the one done last; of two ahead, the one taken back last.
    fn which(&self, of: Option<PastOf>, back: bool) -> Option<PastOf> {
        if of.is_some() {
            return of;
        }
        let views = self.views.next(back).map(|c| (c.number, PastOf::Views));
        let looks = self.looks.next(back).map(|c| (c.number, PastOf::Looks));
        match (views, looks) {
            (Some(v), Some(l)) => Some(if v.0 > l.0 { v.1 } else { l.1 }),
            (one, other) => one.or(other).map(|(_, of)| of),
        }
    }

    /// Numbers of changes behind and ahead.
    pub fn counts(&self, of: Option<PastOf>) -> (usize, usize) {
        let views = (self.views.back.len(), self.views.forward.len());
        let looks = (self.looks.back.len(), self.looks.forward.len());
        match of {
            Some(PastOf::Views) => views,
            Some(PastOf::Looks) => looks,
            None => (views.0 + looks.0, views.1 + looks.1),
        }
    }

    /// Forgets what a scene cannot be: of a project that was written by hand or damaged.
    pub(crate) fn retain(&mut self, scene: &Scene, can_be: impl Fn(&Scene) -> bool) {
        let seen = |views: &Views| can_be(&Scene { views: views.clone().into(), ..scene.clone() });
        let looked = |looks: &Looks| {
            let mut scene = scene.clone();
            looks.clone().exchange(&mut scene);
            can_be(&scene)
        };
        for list in [&mut self.views.back, &mut self.views.forward] {
            list.retain(|change| seen(&change.other));
            list.drain(..list.len().saturating_sub(KEPT));
        }
        for list in [&mut self.looks.back, &mut self.looks.forward] {
            list.retain(|change| looked(&change.other));
            list.drain(..list.len().saturating_sub(KEPT));
        }
    }
}

/// What makes a past of an earlier one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PastDelta {
    views: [ListDelta<Views>; 2],
    looks: [ListDelta<Looks>; 2],
    changes: u64,
}

/// What makes a list of an earlier one: `cut` go at the beginning, `keep` stay after that, the rest goes and `add` comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct ListDelta<T> {
    cut: usize,
    keep: usize,
    add: Vec<Change<T>>,
}

impl<T: Clone + PartialEq> ListDelta<T> {
    fn between(old: &[Change<T>], new: &[Change<T>]) -> Self {
        let cut = new.first().and_then(|first| old.iter().position(|c| c == first)).unwrap_or(0);
        let keep = old[cut..].iter().zip(new).take_while(|(a, b)| a == b).count();
        Self { cut, keep, add: new[keep..].to_vec() }
    }

    fn apply(self, list: &mut Vec<Change<T>>) {
        list.drain(..self.cut.min(list.len()));
        list.truncate(self.keep);
        list.extend(self.add);
    }
}

impl PastDelta {
    /// What makes `new` of `old`; `None` if they are the same.
    pub(crate) fn between(old: &Past, new: &Past) -> Option<Self> {
        (old != new).then(|| Self {
            views: [
                ListDelta::between(&old.views.back, &new.views.back),
                ListDelta::between(&old.views.forward, &new.views.forward),
            ],
            looks: [
                ListDelta::between(&old.looks.back, &new.looks.back),
                ListDelta::between(&old.looks.forward, &new.looks.forward),
            ],
            changes: new.changes,
        })
    }

    /// What makes a past of any other.
    pub(crate) fn whole(past: &Past) -> Self {
        fn all<T: Clone>(line: &Line<T>) -> [ListDelta<T>; 2] {
            [&line.back, &line.forward].map(|list| ListDelta { cut: 0, keep: 0, add: list.clone() })
        }
        Self { views: all(&past.views), looks: all(&past.looks), changes: past.changes }
    }

    /// Makes `past` the later one.
    pub(crate) fn apply(self, past: &mut Past) {
        let ([views_back, views_forward], [looks_back, looks_forward]) = (self.views, self.looks);
        views_back.apply(&mut past.views.back);
        views_forward.apply(&mut past.views.forward);
        looks_back.apply(&mut past.looks.back);
        looks_forward.apply(&mut past.looks.forward);
        past.changes = self.changes;
    }
}
