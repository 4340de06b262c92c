//! A document as it was kept: a generation with its journal laid over it, ready to become a [`State`] again.

use crate::document::disk::error::KeepError;
use crate::document::disk::source_files::SourceFiles;
use crate::document::error::DocumentError;
use crate::document::journal::replay::Replay;
use crate::document::project::fields::Edits;
use crate::document::project::read::{Loaded, LoadedDensity};
use crate::document::scene::kept_poses::{KeptPoses, poses_of_before};
use crate::document::scene::past::Past;
use crate::document::scene::{Origin, Scene};
use crate::document::state::State;
use crate::paint::Sample;
use crate::volume::{BRICK, BrickIndex, BrickSource, DensityMap, Field, FieldKind, Grid, Histogram, Statistics};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// See the module's head.
#[derive(Clone, Debug)]
pub struct KeptDocument {
    /// Everything but voxels.
    pub scene: Scene,
    /// Earlier views and looks.
    pub past: Past,
    /// Where forces had taken the parts.
    pub poses: KeptPoses,
    /// The lattice.
    pub grid: Grid,
    /// How density becomes texels.
    pub map: DensityMap,
    /// Of the source's values.
    pub statistics: Statistics,
    /// Of the source's values.
    pub histogram: Histogram,
    /// Where unedited density is.
    pub density: LoadedDensity,
    /// The files of a linked density; their hash is being compared.
    pub files: Option<Arc<SourceFiles>>,
    /// Edited bricks of each field.
    pub edits: BTreeMap<FieldKind, Edits>,
    /// What came back from the journal.
    pub recovered: Recovered,
}

/// What was done after the last save.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovered {
    /// Commands.
    pub steps: u64,
    /// The last of them as JSON, its places in world millimetres; `null` if there is none.
    pub last: Value,
    /// Samples of the stroke that was running; painting them with the scene's brush finishes it. Say `no_stroke` to the keeper if
    /// that is not wanted.
    pub stroke: Vec<Sample>,
    /// Bytes at the journal's end that were no whole step: the one that was being written.
    pub torn_bytes: u64,
    /// Where a damaged journal was put, and what is wrong with it.
    pub set_aside: Option<(PathBuf, String)>,
    /// What the user should know of the project besides, in sentences.
    pub told: Vec<String>,
}

impl KeptDocument {
    /// `beside` are the poses that lie beside the journal.
    pub(crate) fn new(
        loaded: Loaded,
        replay: Replay,
        beside: Option<KeptPoses>,
        journal: &Path,
    ) -> Result<Self, KeepError> {
        let Loaded { manifest, density, mut edits, files, mut told, .. } = loaded;
        told.extend(replay.told);
        let grid = manifest.grid();
        let bricks = grid.dims.map(|d| d.div_ceil(BRICK));
        if replay.map.is_some() {
            // Texels of the old map; those that are still edits are in the journal.
            edits.insert(FieldKind::Density, Edits::new());
        }
        for ((kind, index), brick) in replay.bricks {
            if (0..3).any(|a| index.0[a] >= bricks[a]) {
                let (found, expected) = (format!("{:?}", index.0), format!("below {bricks:?}"));
                return Err(KeepError::malformed(journal, format!("{} brick", kind.name()), found, expected));
            }
            let field = edits.entry(kind).or_default();
            match brick {
                Some(brick) => field.insert(index, brick),
                None => field.remove(&index),
            };
        }
        let moved = replay.scene.get("explosion").map(poses_of_before).unwrap_or_default();
        let mut scene = if replay.scene.is_empty() {
            manifest.scene.clone()
        } else {
            with_parts(&manifest.scene, replay.scene)
                .map_err(|e| KeepError::malformed(journal, "scene", e, "parts of a scene"))?
        };
        if let LoadedDensity::Linked(path) = &density {
            // The document may have been opened by a path that means nothing here.
            scene.origin.path.clone_from(path);
        }
        // Journals of before have poses too.
        let moved = (!moved.is_empty()).then(|| KeptPoses::at_rest(&scene, moved));
        Ok(Self {
            poses: beside.or(moved).or_else(|| manifest.poses.clone()).unwrap_or_default(),
            scene,
            past: replay.past.unwrap_or_else(|| manifest.past.clone()),
            grid,
            map: replay.map.unwrap_or(manifest.volume.map),
            statistics: manifest.statistics(),
            histogram: manifest.histogram(),
            density,
            files,
            edits,
            recovered: Recovered {
                steps: replay.steps,
                last: replay.last,
                stroke: replay.stroke,
                torn_bytes: replay.torn_bytes,
                set_aside: replay.set_aside,
                told,
            },
        })
    }

    /// The document again. `open` reads the file that the density is linked to and is not called for density in the project.
    /// `progress` gets the share done and answers whether to go on.
    ///
    /// # Errors
    /// If the source fails or has another grid, or `progress` said no.
    pub fn into_state(
        self,
        open: impl FnOnce(&Origin) -> Result<Arc<dyn BrickSource>, DocumentError>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<State, DocumentError> {
        let source: Arc<dyn BrickSource> = match self.density {
            LoadedDensity::Whole(source) => source,
            LoadedDensity::Linked(path) => {
                let source = open(&self.scene.origin)?;
                if source.grid().dims != self.grid.dims {
                    let (found, expected) = (format!("{:?}", source.grid().dims), format!("{:?}", self.grid.dims));
                    return Err(KeepError::malformed(&path, "dims", found, expected).into());
                }
                source
            }
        };
        let density = Field::from_source(source.clone(), self.map, progress)?.ok_or(DocumentError::Stopped)?;
        let mut state = State {
            scene: self.scene,
            past: self.past,
            density,
            colour: Field::blank(FieldKind::Colour, &self.grid),
            selection: Field::blank(FieldKind::Selection, &self.grid),
            labels: Field::blank(FieldKind::Labels, &self.grid),
            source,
            statistics: self.statistics,
            histogram: self.histogram,
            reach: None,
            files: self.files,
        };
        for (kind, edits) in self.edits {
            let changes: Vec<(BrickIndex, _)> = edits.into_iter().map(|(i, brick)| (i, Some(brick))).collect();
            if !changes.is_empty() {
                state.field_mut(kind).swap(changes)?;
            }
        }
        Ok(state)
    }
}

fn with_parts(scene: &Scene, parts: serde_json::Map<String, Value>) -> Result<Scene, serde_json::Error> {
    let mut all = serde_json::to_value(scene)?;
    if let Value::Object(all) = &mut all {
        all.extend(parts);
    }
    serde_json::from_value(all)
}
