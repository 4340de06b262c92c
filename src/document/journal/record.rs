//! Records of the journal: their bytes, written and read.
//!
//! A record is `length u32, checksum 8 bytes, body`; the checksum is the first 8 bytes of the body's blake3. A body is
//! `sequence u64, kind u8, head length u32, head (JSON), bricks`; a brick is `field u8, volume u32, x, y, z u32, state u8` and its
//! content: nothing (0, the edit is gone), 4 bytes (1, uniform), `length u32` and lz4 (2, dense). All little-endian. In version 1
//! there was one volume, and no word of it. Knows no files.

use crate::document::project::first_format;
use crate::document::project::manifest::VolumeRecord;
use crate::document::scene::past::PastDelta;
use crate::paint::Sample;
use crate::volume::{BRICK_VOXELS, Brick, BrickIndex, DensityMap, FieldKey, FieldKind, TexelFormat, VolumeId};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Bytes before a record's body.
pub(crate) const RECORD_HEAD: usize = 12;
const BRICK_HEAD: usize = 18;
/// Of version 1: without the volume.
const OLD_BRICK_HEAD: usize = 14;
/// Where the volume is in a brick's head, and how long.
const VOLUME: std::ops::Range<usize> = 1..5;
/// Bricks of a large step are cut into records of about this size.
const RECORD_BYTES: usize = 4 << 20;

/// What a record says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A command is done.
    Step = 1,
    /// Samples of a stroke that is running.
    Samples = 2,
    /// The running stroke left nothing.
    NoStroke = 3,
    /// State gathered from earlier records.
    Checkpoint = 4,
    /// Bricks of the step or checkpoint that follows; without it they are nothing.
    Part = 5,
}

/// The JSON part of a step or a checkpoint. What did not change is left out.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct StepHead {
    /// The command with its places resolved; a checkpoint has the last one that it gathers.
    pub command: Value,
    /// How many commands it stands for.
    pub steps: u64,
    /// Parts of the scene by name.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub scene: Map<String, Value>,
    /// How density becomes texels, from here on.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub maps: BTreeMap<VolumeId, DensityMap>,
    /// Volumes that came, what was painted on them among the bricks; `null` for those that went.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub volumes: BTreeMap<VolumeId, Option<VolumeRecord>>,
    /// What is new of the past of views and looks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub past: Option<PastDelta>,
}

/// The JSON part of samples, and the running stroke that all of them make.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SamplesHead {
    pub samples: Vec<Sample>,
    /// What is painted; a journal of one volume does not say it.
    #[serde(default)]
    pub volume: VolumeId,
    /// What is painted besides, by a stroke on several volumes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<VolumeId>,
}

impl SamplesHead {
    /// Samples of a stroke on these volumes.
    pub(crate) fn new(samples: Vec<Sample>, volumes: &[VolumeId]) -> Self {
        let (volume, also) = volumes.split_first().map_or_else(Default::default, |(v, also)| (*v, also.to_vec()));
        Self { samples, volume, also }
    }

    /// What is painted, in the order in which it was named.
    pub(crate) fn volumes(&self) -> Vec<VolumeId> {
        std::iter::once(self.volume).chain(self.also.iter().copied()).collect()
    }
}

/// A brick as a record has it: where its bytes are in the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrickEntry {
    pub key: FieldKey,
    pub index: BrickIndex,
    /// Offset of its bytes from the body's start, and how many, head included.
    pub at: (usize, usize),
}

/// A record's body taken apart.
pub(crate) struct Record<'a> {
    pub sequence: u64,
    pub kind: Kind,
    pub head: &'a [u8],
    pub bricks: Vec<BrickEntry>,
}

/// A brick's bytes for a record.
pub(crate) fn encode_brick(key: FieldKey, index: BrickIndex, brick: Option<&Brick>) -> Vec<u8> {
    let mut out = vec![key.kind as u8];
    out.extend(key.volume.0.to_le_bytes());
    out.extend(index.0.iter().flat_map(|i| i.to_le_bytes()));
    match brick {
        None => out.push(0),
        Some(Brick::Uniform(value)) => {
            out.push(1);
            out.extend(value);
        }
        Some(Brick::Dense(texels)) => {
            out.push(2);
            let packed = lz4_flex::block::compress(texels);
            out.extend((packed.len() as u32).to_le_bytes());
            out.extend(packed);
        }
    }
    out
}

/// A brick's bytes of version 1 as they are now.
pub(crate) fn of_first_volume(bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let at = VOLUME.start.min(out.len());
    out.splice(at..at, VolumeId::FIRST.0.to_le_bytes());
    out
}

/// The head of a step of version 1 as it is now; `known` is the scene that it changes.
pub(crate) fn of_first_format(head: &[u8], known: &Map<String, Value>) -> Option<StepHead> {
    let mut head: Value = serde_json::from_slice(head).ok()?;
    let fields = head.as_object_mut()?;
    if let Some(map) = fields.remove("map").filter(|map| !map.is_null()) {
        fields.insert("maps".into(), json!({ "0": map }));
    }
    if let Some(past) = fields.get_mut("past") {
        first_format::looks(past);
    }
    if let Some(scene) = fields.get_mut("scene").and_then(Value::as_object_mut) {
        first_format::parts(scene, known);
    }
    serde_json::from_value(head).ok()
}

/// A brick out of its bytes; `None` inside if the edit is gone. `Err` says what is wrong.
pub(crate) fn decode_brick(bytes: &[u8], format: TexelFormat) -> Result<Option<Brick>, &'static str> {
    let content = bytes.get(BRICK_HEAD..).ok_or("a brick ends early")?;
    match bytes[BRICK_HEAD - 1] {
        0 => Ok(None),
        1 => Ok(Some(Brick::Uniform(content.try_into().map_err(|_| "a uniform brick has not 4 bytes")?))),
        _ => {
            let mut texels = vec![0; BRICK_VOXELS * format.bytes()];
            let packed = content.get(4..).ok_or("a brick ends early")?;
            match lz4_flex::block::decompress_into(packed, &mut texels) {
                Ok(n) if n == texels.len() => Ok(Some(Brick::from_texels(texels, format.bytes()))),
                _ => Err("a brick has not 32³ texels"),
            }
        }
    }
}

/// Ends of the runs of bricks that go into one record each.
pub(crate) fn runs(lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    let (mut ends, mut total, mut count) = (Vec::new(), 0, 0);
    for (i, length) in lengths.enumerate() {
        if total > 0 && total + length > RECORD_BYTES {
            ends.push(i);
            total = 0;
        }
        total += length;
        count = i + 1;
    }
    ends.push(count);
    ends
}

/// A whole record, checksum included.
pub(crate) fn encode(sequence: u64, kind: Kind, head: &[u8], bricks: &[impl AsRef<[u8]>]) -> Vec<u8> {
    let length = 13 + head.len() + bricks.iter().map(|b| b.as_ref().len()).sum::<usize>();
    let mut out = Vec::with_capacity(RECORD_HEAD + length);
    out.extend((length as u32).to_le_bytes());
    out.extend([0; 8]);
    out.extend(sequence.to_le_bytes());
    out.push(kind as u8);
    out.extend((head.len() as u32).to_le_bytes());
    out.extend(head);
    bricks.iter().for_each(|b| out.extend(b.as_ref()));
    let sum = checksum(&out[RECORD_HEAD..]);
    out[4..RECORD_HEAD].copy_from_slice(&sum);
    out
}

/// The first 8 bytes of the body's blake3.
pub(crate) fn checksum(body: &[u8]) -> [u8; 8] {
    let hash = blake3::hash(body);
    std::array::from_fn(|i| hash.as_bytes()[i])
}

/// Takes a body apart, of version 1 if it is `old`; `None` if it is none.
pub(crate) fn decode(body: &[u8], old: bool) -> Option<Record<'_>> {
    let sequence = u64::from_le_bytes(body.get(..8)?.try_into().ok()?);
    let kind = match body.get(8)? {
        1 => Kind::Step,
        2 => Kind::Samples,
        3 => Kind::NoStroke,
        4 => Kind::Checkpoint,
        5 => Kind::Part,
        _ => return None,
    };
    let head_end = 13 + u32::from_le_bytes(body.get(9..13)?.try_into().ok()?) as usize;
    let head = body.get(13..head_end)?;
    let head_bytes = if old { OLD_BRICK_HEAD } else { BRICK_HEAD };
    let mut bricks = Vec::new();
    let mut at = head_end;
    while at < body.len() {
        let entry = body.get(at..at + head_bytes)?;
        let kind = *FieldKind::ALL.get(entry[0] as usize)?;
        let number = |i: usize| u32::from_le_bytes([entry[i], entry[i + 1], entry[i + 2], entry[i + 3]]);
        let volume = if old { VolumeId::FIRST } else { VolumeId(number(VOLUME.start)) };
        let index = BrickIndex([13, 9, 5].map(|before_end| number(head_bytes - before_end)));
        let content = match entry[head_bytes - 1] {
            0 => 0,
            1 => 4,
            2 => {
                let length = body.get(at + head_bytes..at + head_bytes + 4)?;
                4 + u32::from_le_bytes(length.try_into().ok()?) as usize
            }
            _ => return None,
        };
        let length = head_bytes + content;
        body.get(at..at + length)?;
        bricks.push(BrickEntry { key: FieldKey::new(volume, kind), index, at: (at, length) });
        at += length;
    }
    Some(Record { sequence, kind, head, bricks })
}
