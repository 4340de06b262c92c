//! A step as bytes, in memory or in a file: a JSON head, the commands that made it as JSON, then its bricks under LZ4.

use crate::document::command::resolved::ResolvedCommand;
use crate::document::history::step::{SceneDelta, Step};
use crate::volume::{Brick, BrickIndex, DensityMap, FieldKey, VolumeId};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

#[derive(Serialize, Deserialize)]
enum Shape {
    Unedited,
    Uniform([u8; 4]),
    /// Compressed and plain length.
    Dense(usize, usize),
}

#[derive(Serialize, Deserialize)]
struct Head {
    /// Length of the commands, which nothing depends on: what JSON cannot say of them is left out.
    commands: usize,
    scene: SceneDelta,
    maps: Vec<(VolumeId, DensityMap)>,
    bricks: Vec<(FieldKey, BrickIndex, Shape)>,
}

/// Where a step's bytes are.
#[derive(Debug)]
pub(crate) enum Packed {
    Memory(Vec<u8>),
    File { path: PathBuf, bytes: u64, hash: blake3::Hash },
}

impl Packed {
    /// Compresses a step.
    pub(crate) fn new(step: &Step) -> Result<Self, String> {
        let payload: Vec<Vec<u8>> = step
            .bricks
            .par_iter()
            .map(|(_, brick)| match brick {
                Some(Brick::Dense(texels)) => lz4_flex::compress(texels),
                _ => Vec::new(),
            })
            .collect();
        let shapes = step.bricks.iter().zip(&payload).map(|((&(key, index), brick), bytes)| {
            let shape = match brick {
                None => Shape::Unedited,
                Some(Brick::Uniform(value)) => Shape::Uniform(*value),
                Some(Brick::Dense(texels)) => Shape::Dense(bytes.len(), texels.len()),
            };
            (key, index, shape)
        });
        let commands = serde_json::to_vec(&step.commands).unwrap_or_default();
        let head = Head {
            commands: commands.len(),
            scene: step.scene.clone(),
            maps: step.maps.clone().into_iter().collect(),
            bricks: shapes.collect(),
        };
        let head = serde_json::to_vec(&head).map_err(|e| format!("a step cannot be written down: {e}"))?;
        let mut bytes =
            Vec::with_capacity(8 + head.len() + commands.len() + payload.iter().map(Vec::len).sum::<usize>());
        bytes.extend_from_slice(&(head.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&head);
        bytes.extend_from_slice(&commands);
        payload.iter().for_each(|p| bytes.extend_from_slice(p));
        Ok(Self::Memory(bytes))
    }

    /// Memory in bytes.
    pub(crate) fn memory(&self) -> u64 {
        match self {
            Self::Memory(bytes) => bytes.len() as u64,
            Self::File { .. } => 0,
        }
    }

    /// Disk in bytes.
    pub(crate) fn disk(&self) -> u64 {
        match self {
            Self::Memory(_) => 0,
            Self::File { bytes, .. } => *bytes,
        }
    }

    /// Moves the bytes to a file that must not exist yet.
    pub(crate) fn spill(&mut self, path: &Path) -> Result<(), String> {
        let Self::Memory(bytes) = self else { return Ok(()) };
        let said = |e: std::io::Error| format!("an older step of history cannot go to {}: {e}", path.display());
        if let Err(error) = std::fs::write(path, &*bytes) {
            // What little was written would only keep the disk full.
            let _ = std::fs::remove_file(path);
            return Err(said(error));
        }
        *self = Self::File { path: path.into(), bytes: bytes.len() as u64, hash: blake3::hash(bytes) };
        Ok(())
    }

    /// The step again, under the name that the list of steps keeps.
    pub(crate) fn load(&self, name: &str) -> Result<Step, String> {
        self.read(name, |bytes| parse(bytes, name))
    }

    /// The commands that made it.
    pub(crate) fn commands(&self, name: &str) -> Result<Vec<ResolvedCommand>, String> {
        self.read(name, |bytes| Some(head_of(bytes)?.1))
    }

    fn read<T>(&self, name: &str, parse: impl FnOnce(&[u8]) -> Option<T>) -> Result<T, String> {
        match self {
            Self::Memory(bytes) => parse(bytes).ok_or_else(|| format!("step \"{name}\": its bytes are damaged")),
            Self::File { path, hash, .. } => {
                let said = |what: String| format!("step \"{name}\": {}: {what}", path.display());
                let bytes = std::fs::read(path).map_err(|e| said(e.to_string()))?;
                if blake3::hash(&bytes) != *hash {
                    return Err(said("the file was changed by another program".into()));
                }
                parse(&bytes).ok_or_else(|| said("the file is damaged".into()))
            }
        }
    }
}

impl Drop for Packed {
    fn drop(&mut self) {
        if let Self::File { path, .. } = self {
            // The folder is temporary: what cannot be removed now goes with it.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The head, the commands, and where the bricks begin.
fn head_of(bytes: &[u8]) -> Option<(Head, Vec<ResolvedCommand>, usize)> {
    let length = u64::from_le_bytes(bytes.get(..8)?.try_into().ok()?);
    let end = 8_usize.checked_add(usize::try_from(length).ok()?)?;
    let head: Head = serde_json::from_slice(bytes.get(8..end)?).ok()?;
    let begin = end.checked_add(head.commands)?;
    let commands = serde_json::from_slice(bytes.get(end..begin)?).unwrap_or_default();
    Some((head, commands, begin))
}

fn parse(bytes: &[u8], name: &str) -> Option<Step> {
    let (head, commands, begin) = head_of(bytes)?;
    let mut step = Step {
        name: name.into(),
        commands,
        scene: head.scene,
        maps: head.maps.into_iter().collect(),
        ..Step::default()
    };
    let mut at = begin;
    for (key, index, shape) in head.bricks {
        let brick = match shape {
            Shape::Unedited => None,
            Shape::Uniform(value) => Some(Brick::Uniform(value)),
            Shape::Dense(packed, plain) => {
                let next = at.checked_add(packed)?;
                let texels = lz4_flex::decompress(bytes.get(at..next)?, plain).ok()?;
                at = next;
                Some(Brick::Dense(texels.into()))
            }
        };
        step.bricks.insert((key, index), brick);
    }
    Some(step)
}
