//! The journal: what was done since the last save, on disk before the answer is given.
//!
//! Append-only. Every step carries the content of the bricks that it touched and the parts of the scene that it changed, so
//! that recovery lays down final content and executes nothing. Samples of a running stroke are appended as they arrive,
//! without waiting for the disk. The file belongs to one generation and its records count up without a gap: nothing is
//! replayed twice, and a torn tail ends the journal before it. When most of it is superseded, what is still true is gathered
//! into a new file, so that recovery grows with the bricks touched and not with history. What could not be written stays
//! in memory and goes first the next time.

pub(crate) mod autosave;
pub(crate) mod generation;
pub(crate) mod loaded;
pub(crate) mod now;
pub(crate) mod poses_file;
pub(crate) mod record;
pub mod recovery;
pub(crate) mod replay;

use crate::document::command::Command;
use crate::document::command::effects::Noted;
use crate::document::disk::error::KeepError;
use crate::document::disk::files::sync_dir;
use crate::document::journal::now::{Beginning, Now, parts};
use crate::document::journal::record::{
    BrickEntry, Kind, RECORD_HEAD, SamplesHead, StepHead, decode, encode, encode_brick, of_first_volume, runs,
};
use crate::document::project::manifest::JOURNAL_HEADER;
use crate::document::scene::past::PastDelta;
use crate::document::scene::{Scene, components};
use crate::document::state::State;
use crate::io::disk;
use crate::paint::Sample;
use crate::volume::{BrickIndex, FieldKey, FieldKind, VolumeId};
use rayon::prelude::*;
use serde_json::{Map, Value};
use std::collections::{BTreeSet, HashMap, VecDeque};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub(crate) const MAGIC: &[u8; 8] = b"BURINJNL";
pub(crate) const VERSION: u32 = 2;
/// Of one volume; it is read and gathered into one of today's.
pub(crate) const ONE_VOLUME: u32 = 1;
/// A journal below this is not worth gathering.
const GATHER_ABOVE: u64 = 4 << 20;

/// An open journal: its file, where its records end, and what is not yet written.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
    /// Where the next record goes.
    pub(crate) end: u64,
    generation: u64,
    pub(crate) sequence: u64,
    /// What the records so far lead to, on top of the generation.
    pub(crate) now: Now,
    /// Where the latest content of each touched brick is: offset and length.
    pub(crate) live: HashMap<(FieldKey, BrickIndex), (u64, usize)>,
    live_bytes: u64,
    pub(crate) stroke_runs: bool,
    /// Whether the file is of version 1.
    pub(crate) old: bool,
    /// Records that the disk refused.
    pending: VecDeque<Vec<u8>>,
    gather_above: u64,
    /// Its length when it was opened; `None` once what was found then is gathered with what came later.
    pub(crate) found: Option<u64>,
    /// Volumes that were exchanged for others of their names and are not in it yet.
    exchanged: BTreeSet<VolumeId>,
}

impl Journal {
    /// An empty journal for a generation that has all this. Replaces a file of that name.
    pub(crate) fn create(path: &Path, beginning: Beginning<'_>) -> Result<Self, KeepError> {
        let generation = beginning.generation;
        let file = start(path, generation, 1)?;
        path.parent().map_or(Ok(()), sync_dir)?;
        Ok(Self::over(path, file, generation, 0, Now::new(beginning)?))
    }

    /// A journal over an open file, before its first record.
    pub(crate) fn over(path: &Path, file: File, generation: u64, sequence: u64, now: Now) -> Self {
        Self {
            path: path.to_owned(),
            file,
            end: JOURNAL_HEADER,
            generation,
            sequence,
            now,
            live: HashMap::new(),
            live_bytes: 0,
            stroke_runs: false,
            old: false,
            pending: VecDeque::new(),
            gather_above: GATHER_ABOVE,
            found: Some(JOURNAL_HEADER),
            exchanged: BTreeSet::new(),
        }
    }

    /// Writes a step: the command, what it changed in the scene, and what the bricks that it touched hold now. After a change
    /// of map all edited density is written, since texels of another map mean nothing; so is all of a volume that was `exchanged`.
    pub(crate) fn step(
        &mut self,
        command: &Command,
        state: &State,
        (touched, exchanged): (&[(FieldKey, BrickIndex)], &BTreeSet<VolumeId>),
        synced: bool,
    ) -> Result<(), KeepError> {
        self.exchanged.extend(exchanged);
        let scene = parts(&state.scene)?;
        let known = self.now.scene();
        let changed: Map<String, Value> =
            scene.iter().filter(|(k, v)| known.get(*k) != Some(v)).map(|(k, v)| (k.clone(), v.clone())).collect();
        if !changed.is_empty() {
            // A number that JSON has no word for would make all that follows unreadable: better refused now.
            let back: Result<Scene, _> = serde_json::from_value(Value::Object(scene));
            back.map_err(|e| KeepError::Scene { reason: e.to_string() })?;
        }
        let (volumes, maps) = self.now.difference(state, &self.exchanged)?;
        let noted = command.effects().journal;
        let ends_stroke = noted == Noted::Stroke;
        // Looking about is no step of work. In what was opened and never saved it is nothing to lose: the first step takes it along.
        let known_parts = changed.keys().all(|part| Scene::kept(part).is_some_and(components::TakenBackBy::is_idle));
        let is_plain = maps.is_empty() && volumes.is_empty() && touched.is_empty();
        let looks_about = known_parts && !ends_stroke && is_plain;
        if looks_about && self.generation == 0 && self.now.steps == 0 && !self.stroke_runs {
            return Ok(());
        }
        // What a file was opened as is read again from the file, and no step of work either.
        let opens = noted == Noted::Opening;
        let command = serde_json::to_value(command).map_err(|e| KeepError::Scene { reason: e.to_string() })?;
        let past = PastDelta::between(self.now.past(), &state.past);
        let head = StepHead { command, steps: u64::from(!looks_about && !opens), scene: changed, maps, volumes, past };
        let bytes = head_bytes(&head)?;
        // Of a volume that came all is written; what was touched may have been of another one of its name.
        let touched = touched.iter().filter(|(key, _)| !head.volumes.contains_key(&key.volume));
        let mut places: BTreeSet<(FieldKey, BrickIndex)> = touched.copied().collect();
        for (&id, volume) in &state.volumes {
            let came = head.volumes.contains_key(&id);
            for kind in FieldKind::ALL {
                if came || (kind == FieldKind::Density && head.maps.contains_key(&id)) {
                    let key = FieldKey::new(id, kind);
                    places.extend(volume.field(kind).edits().into_keys().map(|index| (key, index)));
                }
            }
        }
        self.take(head);
        self.exchanged.clear();
        if ends_stroke {
            self.stroke_runs = false;
        }
        let places: Vec<_> = places.into_iter().filter(|(key, _)| state.volumes.contains_key(&key.volume)).collect();
        let encode = |&(key, index)| encode_brick(key, index, state.field(key).and_then(|field| field.edit(index)));
        let bricks: Vec<Vec<u8>> = places.par_iter().map(encode).collect();
        let ends = runs(bricks.iter().map(Vec::len));
        let (mut from, last) = (0, ends.len() - 1);
        for (i, to) in ends.into_iter().enumerate() {
            let (kind, head) = if i == last { (Kind::Step, &bytes[..]) } else { (Kind::Part, &b"{}"[..]) };
            self.push(kind, head, &bricks[from..to]);
            from = to;
        }
        self.flush(synced)?;
        if !self.stroke_runs && self.end > self.gather_above.saturating_add(4 * self.live_bytes) {
            // All is safe as it is; a gathering that fails only has to be tried later.
            if let Err(error) = self.gather() {
                tracing::warn!("{error}");
                self.gather_above = self.end.saturating_mul(2);
            }
        }
        Ok(())
    }

    /// Writes samples of a stroke that runs on these volumes; does not wait for the disk.
    pub(crate) fn samples(&mut self, volumes: &[VolumeId], samples: &[Sample]) -> Result<(), KeepError> {
        self.stroke_runs = true;
        let head = head_bytes(&SamplesHead::new(samples.to_vec(), volumes))?;
        self.push(Kind::Samples, &head, &[]);
        self.flush(false)
    }

    /// Notes that the running stroke was taken back or changed nothing.
    pub(crate) fn no_stroke(&mut self) -> Result<(), KeepError> {
        if !std::mem::take(&mut self.stroke_runs) {
            return Ok(());
        }
        self.push(Kind::NoStroke, b"{}", &[]);
        self.flush(false)
    }

    /// Whether it held anything when it was opened.
    pub(crate) fn found_anything(&self) -> bool {
        self.found != Some(JOURNAL_HEADER)
    }

    /// Takes off what was written since it was opened. What was gathered meanwhile cannot be told apart and stays.
    pub(crate) fn leave_as_found(self) -> Result<(), KeepError> {
        let Some(found) = self.found else { return Ok(()) };
        self.file.set_len(found).and_then(|()| self.file.sync_all()).map_err(KeepError::io("shorten", &self.path))
    }

    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    fn push(&mut self, kind: Kind, head: &[u8], bricks: &[Vec<u8>]) {
        self.sequence += 1;
        self.pending.push_back(encode(self.sequence, kind, head, bricks));
    }

    fn flush(&mut self, synced: bool) -> Result<(), KeepError> {
        while let Some(record) = self.pending.front() {
            // Always at the known end: what a failed write left there is overwritten, or ends the journal as a torn tail.
            let written = self.file.seek(SeekFrom::Start(self.end)).and_then(|_| self.file.write_all(record));
            written.map_err(KeepError::io("write", &self.path))?;
            let Some(record) = self.pending.pop_front() else { break };
            let entries = decode(&record[RECORD_HEAD..], false).map(|r| r.bricks).unwrap_or_default();
            self.note(&entries, self.end + RECORD_HEAD as u64);
            self.end += record.len() as u64;
        }
        if synced {
            disk::sync_data(&self.file, &self.path).map_err(KeepError::io("sync", &self.path))?;
        }
        Ok(())
    }

    /// Notes where bricks are now; their body begins at `body_at`.
    pub(crate) fn note(&mut self, entries: &[BrickEntry], body_at: u64) {
        for entry in entries {
            let (offset, length) = entry.at;
            self.live_bytes += length as u64;
            if let Some((_, old)) = self.live.insert((entry.key, entry.index), (body_at + offset as u64, length)) {
                self.live_bytes -= old as u64;
            }
        }
    }

    /// Takes in a record's head. Texels of another map mean nothing, nor does what was painted on a volume that went.
    pub(crate) fn take(&mut self, head: StepHead) {
        let (volumes, maps) = (&head.volumes, &head.maps);
        self.live.retain(|(key, _), _| {
            let is_density = key.kind == FieldKind::Density;
            !(volumes.contains_key(&key.volume) || (is_density && maps.contains_key(&key.volume)))
        });
        self.now.take(head);
        self.live_bytes = self.live.values().map(|(_, length)| *length as u64).sum();
    }

    /// Gathers what is still true into a new file and puts it in this one's place.
    pub(crate) fn gather(&mut self) -> Result<(), KeepError> {
        let beside = self.path.with_extension("gathered");
        let doing = |e| KeepError::io("gather", &beside)(e);
        let mut file = start(&beside, self.generation, self.sequence + 1)?;
        let now = &self.now;
        let head = StepHead {
            command: now.last.clone(),
            steps: now.steps,
            scene: now.changed.clone(),
            maps: now.new_maps.clone(),
            volumes: now.volumes.clone(),
            past: now.new_past.then(|| PastDelta::whole(now.past())),
        };
        let mut places: Vec<_> = self.live.values().copied().collect();
        places.sort_unstable();
        let ends = runs(places.iter().map(|(_, length)| *length));
        let (mut end, mut sequence, mut from) = (JOURNAL_HEADER, self.sequence, 0);
        let mut noted = Vec::new();
        for (i, &to) in ends.iter().enumerate() {
            let mut bricks = Vec::new();
            for &(at, length) in &places[from..to] {
                let mut bytes = vec![0; length];
                let read = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.read_exact(&mut bytes));
                read.map_err(doing)?;
                bricks.push(if self.old { of_first_volume(&bytes) } else { bytes });
            }
            from = to;
            sequence += 1;
            let is_last = i + 1 == ends.len();
            let (kind, head) =
                if is_last { (Kind::Checkpoint, head_bytes(&head)?) } else { (Kind::Part, b"{}".to_vec()) };
            let record = encode(sequence, kind, &head, &bricks);
            file.write_all(&record).map_err(doing)?;
            let entries = decode(&record[RECORD_HEAD..], false).map(|r| r.bricks).unwrap_or_default();
            noted.push((entries, end + RECORD_HEAD as u64));
            end += record.len() as u64;
        }
        disk::sync(&file, &beside).map_err(doing)?;
        disk::rename(&beside, &self.path).map_err(doing)?;
        // From here on the path names the new file.
        (self.file, self.end, self.sequence, self.old) = (file, end, sequence, false);
        self.found = self.found.filter(|&found| found == JOURNAL_HEADER);
        noted.iter().for_each(|(entries, body_at)| self.note(entries, *body_at));
        self.path.parent().map_or(Ok(()), sync_dir)
    }
}

fn head_bytes(head: &impl serde::Serialize) -> Result<Vec<u8>, KeepError> {
    serde_json::to_vec(head).map_err(|e| KeepError::Scene { reason: e.to_string() })
}

/// A new file with its header, synced.
fn start(path: &Path, generation: u64, first_sequence: u64) -> Result<File, KeepError> {
    let mut header = MAGIC.to_vec();
    header.extend(VERSION.to_le_bytes());
    header.extend(generation.to_le_bytes());
    header.extend(first_sequence.to_le_bytes());
    let write = || {
        let mut file = crate::document::disk::inside::create_anew(path)?;
        let begun = file.write_all(&header).and_then(|()| disk::sync(&file, path));
        if begun.is_err() {
            // Half a header would be taken for damage.
            let _ = std::fs::remove_file(path);
        }
        begun.map(|()| file)
    };
    write().map_err(KeepError::io("write", path))
}
