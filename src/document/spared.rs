//! What of a body stands in windows as it was: selected matter, or that of segments.
//!
//! A body of which windows spare some is divided by label, as it is where segments have looks of their own, and each piece says which
//! windows leave it alone. Knows no meshes.

use crate::document::scene::Scene;
use crate::document::scene::cutaways::Spared;
use crate::document::subject::Subject;
use crate::gpu::{Body, LabelLooks, Mask};
use crate::volume::VolumeId;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A window that stands open and spares something.
#[derive(Clone, Debug)]
pub(crate) struct Sparing<'a> {
    id: u32,
    of: &'a Spared,
    /// Whose segments.
    root: VolumeId,
}

impl Scene {
    /// The windows that stand open and spare something.
    pub(crate) fn sparing(&self) -> Vec<Sparing<'_>> {
        let open = self.cutaways.all.iter().filter(|(_, one)| one.open && !one.spares.is_nothing());
        open.map(|(id, one)| Sparing { id: id.0, of: &one.spares, root: self.root_of(one.anchor.volume) }).collect()
    }
}

/// Whether any of them spares selected matter, which is then a body of its own.
pub(crate) fn any_selection(sparing: &[Sparing<'_>]) -> bool {
    sparing.iter().any(|one| one.of.selection)
}

/// A body that has looks as one or more, each with the windows that spare it.
pub(crate) fn divided(subject: &Subject<'_>, body: Body, sparing: &[Sparing<'_>]) -> Vec<Body> {
    let root = subject.scene.root_of(subject.id);
    let of_selection = |one: &&Sparing<'_>| one.of.selection && body.mask == Mask::Selection;
    let always: BTreeSet<u32> = sparing.iter().filter(of_selection).map(|one| one.id).collect();
    let mut by_label: BTreeMap<u16, BTreeSet<u32>> = BTreeMap::new();
    if !subject.labels.is_blank() {
        for one in sparing.iter().filter(|one| one.root == root) {
            for label in &one.of.segments {
                by_label.entry(*label).or_insert_with(|| always.clone()).insert(one.id);
            }
        }
    }
    by_label.retain(|_, ids| *ids != always);
    let list = |ids: &BTreeSet<u32>| -> Arc<[u32]> { ids.iter().copied().collect() };
    if by_label.is_empty() {
        return vec![Body { spared_by: list(&always), ..body }];
    }
    let row = |label: u16| body.labels.as_ref().map_or(body.look, |labels| labels.row(label));
    let mut rest = body.labels.as_deref().cloned().unwrap_or(LabelLooks { default: body.look, ..Default::default() });
    let mut groups: BTreeMap<&BTreeSet<u32>, LabelLooks> = BTreeMap::new();
    for (label, ids) in &by_label {
        rest.by_label.insert(*label, None);
        groups.entry(ids).or_default().by_label.insert(*label, row(*label));
    }
    let always = list(&always);
    let mut bodies = vec![(rest, always)];
    bodies.extend(groups.into_iter().map(|(ids, labels)| (labels, list(ids))));
    let shown = bodies.into_iter().filter(|(labels, _)| !labels.rows().is_empty());
    shown.map(|(labels, spared_by)| Body { labels: Some(Arc::new(labels)), spared_by, ..body.clone() }).collect()
}
