//! Reading a journal back, up to the last step that is whole.
//!
//! Nothing is executed: the latest content of every touched brick and the latest parts of the scene are found, and laid over
//! the generation. Memory follows the bricks touched, never what a damaged length claims.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use crate::document::journal::now::{Beginning, Now};
use crate::document::journal::record::{
    BrickEntry, Kind, RECORD_HEAD, Record, SamplesHead, StepHead, checksum, decode, decode_brick, of_first_format,
    of_first_volume,
};
use crate::document::journal::{Journal, MAGIC, ONE_VOLUME, VERSION};
use crate::document::project::manifest::{JOURNAL_HEADER, VolumeRecord};
use crate::document::scene::past::Past;
use crate::volume::{Brick, BrickIndex, DensityMap, FieldKey, VolumeId};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// What a journal brings back.
#[derive(Debug, Default)]
pub(crate) struct Replay {
    /// Commands beyond the generation.
    pub steps: u64,
    /// The last of them, `null` if there is none.
    pub last: Value,
    /// Parts of the scene that they changed.
    pub scene: Map<String, Value>,
    /// The past of views and looks, if they changed it.
    pub past: Option<Past>,
    /// The density maps that they changed: all edited density of those volumes is in `bricks`.
    pub maps: BTreeMap<VolumeId, DensityMap>,
    /// Volumes that came, all that is painted on them in `bricks`, or went (`None`).
    pub volumes: BTreeMap<VolumeId, Option<VolumeRecord>>,
    /// The bricks that they touched, `None` where an edit is gone.
    pub bricks: BTreeMap<(FieldKey, BrickIndex), Option<Brick>>,
    /// The stroke that was running; without samples if none was.
    pub stroke: SamplesHead,
    /// Bytes at the end that are no whole step.
    pub torn_bytes: u64,
    /// Where a copy of the journal was put because a record in it is damaged, not merely unfinished; and what is wrong.
    pub set_aside: Option<(PathBuf, String)>,
    /// What is wrong with it, where it is left as it is.
    pub told: Option<String>,
}

/// No record is longer: what is left of a file behind the last whole one and is more was not being written.
const MOST_UNFINISHED: u64 = 64 << 20;
/// Records that one file may have.
const MOST_AT_ONCE: u64 = 1 << 32;

fn lost(what: &str, bytes: u64) -> String {
    format!("{what}; the {bytes} bytes from there on, with the steps in them, are lost")
}

impl Journal {
    /// Reads a journal and goes on where its last whole step ends. `Ok(None)` if there is none.
    pub(crate) fn resume(path: &Path, beginning: Beginning<'_>) -> Result<Option<(Self, Replay)>, KeepError> {
        let (dir, name) = place(path);
        let mut file = match inside::open_to_write(dir, &name) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            opened => opened.map_err(KeepError::io("open", path))?,
        };
        if is_unbegun(path, &file)? {
            return Ok(None);
        }
        if inside::has_other_names(&file).map_err(KeepError::io("read", path))? {
            // A copy of the project by links: what is noted here is not noted there.
            let alone = path.with_extension("alone");
            copy(&mut file, &alone)
                .and_then(|()| std::fs::rename(&alone, path))
                .map_err(KeepError::io("copy", path))?;
            file = inside::open_to_write(dir, &name).map_err(KeepError::io("open", path))?;
        }
        let shorten = file.try_clone().map_err(KeepError::io("open", path))?;
        let (mut journal, mut replay, damage) = Self::read(path, file, beginning)?;
        journal.found = Some(journal.end);
        replay.set_aside = damage.map(|what| set_aside(path, lost(&what, replay.torn_bytes))).transpose()?;
        shorten.set_len(journal.end).map_err(KeepError::io("shorten", path))?;
        if journal.old {
            journal.gather()?;
            if !replay.stroke.samples.is_empty() {
                journal.samples(&replay.stroke.volumes(), &replay.stroke.samples)?;
            }
        }
        Ok(Some((journal, replay)))
    }

    /// Reads a journal that somebody else may be writing; changes nothing.
    pub(crate) fn look(path: &Path, beginning: Beginning<'_>) -> Result<Option<Replay>, KeepError> {
        let (dir, name) = place(path);
        let file = match inside::open(dir, &name) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            opened => opened.map_err(KeepError::io("open", path))?,
        };
        if is_unbegun(path, &file)? {
            return Ok(None);
        }
        let (_, mut replay, damage) = Self::read(path, file, beginning)?;
        replay.told = damage.map(|what| format!("{} is damaged: {}", path.display(), lost(&what, replay.torn_bytes)));
        Ok(Some(replay))
    }

    /// Whether a journal holds what somebody did: a step that counts as one, or a stroke that was running. What cannot be read may
    /// be work too. Reads up to the first step, changes nothing.
    pub(crate) fn holds_work(path: &Path) -> Result<bool, KeepError> {
        let (dir, name) = place(path);
        let reading = |e| KeepError::io("read", path)(e);
        let file = inside::open(dir, &name).map_err(reading)?;
        let mut left = file.metadata().map_err(reading)?.len().saturating_sub(JOURNAL_HEADER);
        let old = is_old(&file).map_err(reading)?;
        let mut reader = BufReader::with_capacity(1 << 20, file);
        reader.seek(SeekFrom::Start(JOURNAL_HEADER)).map_err(reading)?;
        let (mut body, mut stroke) = (Vec::new(), SamplesHead::default());
        while left > 0 {
            let Body::Whole = next_body(&mut reader, left, &mut body).map_err(reading)? else { return Ok(true) };
            left -= (RECORD_HEAD + body.len()) as u64;
            let head = decode(&body, old).and_then(|record| read_head(&record, old, &Map::new(), &mut stroke));
            if head.is_none_or(|head| head.steps > 0) {
                return Ok(true);
            }
        }
        Ok(!stroke.samples.is_empty())
    }

    /// The journal up to its last whole step, what it brings back, and what is wrong with the record after that if it is more
    /// than unfinished.
    fn read(path: &Path, file: File, beginning: Beginning<'_>) -> Result<(Self, Replay, Option<String>), KeepError> {
        let generation = beginning.generation;
        let length = file.metadata().map_err(KeepError::io("read", path))?.len();
        let (version, first) = read_header(path, &file, generation)?;
        let reader = file.try_clone().map_err(KeepError::io("open", path))?;
        let mut journal = Self::over(path, file, generation, first - 1, Now::new(beginning)?);
        journal.old = version == ONE_VOLUME;
        let mut reader = BufReader::with_capacity(1 << 20, reader);
        let (stroke, damage) = journal.read_records(&mut reader, length)?;
        let now = &journal.now;
        let replay = Replay {
            steps: now.steps,
            last: now.last.clone(),
            scene: now.changed.clone(),
            past: now.new_past.then(|| now.past().clone()),
            maps: now.new_maps.clone(),
            volumes: now.volumes.clone(),
            bricks: journal.read_bricks(&mut reader)?,
            stroke,
            torn_bytes: length - journal.end,
            set_aside: None,
            told: None,
        };
        Ok((journal, replay, damage))
    }

    /// Takes in all whole steps. Answers the stroke that was running, and what is wrong with the record that ended the reading
    /// if it is more than unfinished.
    fn read_records(
        &mut self,
        reader: &mut BufReader<File>,
        length: u64,
    ) -> Result<(SamplesHead, Option<String>), KeepError> {
        let path = self.path().to_owned();
        reader.seek(SeekFrom::Start(JOURNAL_HEADER)).map_err(KeepError::io("read", &path))?;
        let (mut at, mut sequence) = (self.end, self.sequence);
        let mut body = Vec::new();
        let mut stroke = SamplesHead::default();
        // Bricks whose step has not come yet, with the offset of their body.
        let mut waiting: Vec<(Vec<BrickEntry>, u64)> = Vec::new();
        let damage = loop {
            let whole = match next_body(reader, length - at, &mut body).map_err(KeepError::io("read", &path))? {
                Body::Short if is_followed(reader, at, length, sequence).map_err(KeepError::io("read", &path))? => {
                    break Some(format!("record at byte {at}: it is longer than the file, and others come after it"));
                }
                Body::Short => break None,
                Body::Damaged => break Some(format!("record at byte {at}: its checksum does not match")),
                Body::Whole => decode(&body, self.old).filter(|r| r.sequence == sequence + 1),
            };
            let Some((record, head)) =
                whole.and_then(|r| read_head(&r, self.old, self.now.scene(), &mut stroke).map(|head| (r, head)))
            else {
                break Some(format!("record at byte {at}: it is not the one after {sequence}"));
            };
            sequence = record.sequence;
            let body_at = at + RECORD_HEAD as u64;
            at = body_at + body.len() as u64;
            waiting.push((record.bricks, body_at));
            if record.kind == Kind::Part {
                continue;
            }
            self.take(head);
            waiting.drain(..).for_each(|(entries, body_at)| self.note(&entries, body_at));
            (self.end, self.sequence) = (at, sequence);
        };
        self.stroke_runs = !stroke.samples.is_empty();
        Ok((stroke, damage))
    }

    fn read_bricks(
        &self,
        reader: &mut BufReader<File>,
    ) -> Result<BTreeMap<(FieldKey, BrickIndex), Option<Brick>>, KeepError> {
        let mut places: Vec<_> = self.live.iter().map(|(key, at)| (*at, *key)).collect();
        places.sort_unstable();
        let mut bytes = Vec::new();
        let mut bricks = BTreeMap::new();
        for ((at, length), (key, index)) in places {
            bytes.resize(length, 0);
            let read = reader.seek(SeekFrom::Start(at)).and_then(|_| reader.read_exact(&mut bytes));
            read.map_err(KeepError::io("read", self.path()))?;
            let bad = |found: &str, expected: &str| {
                let field = format!("{} brick {:?}", key.kind.name(), index.0);
                KeepError::malformed(self.path(), field, found, expected)
            };
            let Some(map) = self.now.map(key.volume) else {
                return Err(bad(&format!("volume {}", key.volume), "a volume that the document has"));
            };
            let format = key.kind.format(map.format);
            let bytes = if self.old { of_first_volume(&bytes) } else { bytes.clone() };
            let brick =
                decode_brick(&bytes, format).map_err(|found| bad(found, "a brick that unpacks to 32³ texels"))?;
            bricks.insert((key, index), brick);
        }
        Ok(bricks)
    }
}

/// Whether a journal is of version 1.
fn is_old(mut file: &File) -> std::io::Result<bool> {
    let mut version = [0; 4];
    file.seek(SeekFrom::Start(8)).and_then(|_| file.read_exact(&mut version))?;
    Ok(u32::from_le_bytes(version) == ONE_VOLUME)
}

/// Checks the header and answers version and the first record's sequence.
fn read_header(path: &Path, mut file: &File, generation: u64) -> Result<(u32, u64), KeepError> {
    let mut header = [0; JOURNAL_HEADER as usize];
    match file.seek(SeekFrom::Start(0)).and_then(|_| file.read_exact(&mut header)) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
            return Err(KeepError::malformed(path, "header", "fewer bytes", format!("{JOURNAL_HEADER} bytes")));
        }
        other => other.map_err(KeepError::io("read", path))?,
    }
    let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| header[at + i]));
    if header[..8] != *MAGIC {
        return Err(KeepError::malformed(path, "header", format!("{:?}", &header[..8]), "the mark of a journal"));
    }
    let version = u32::from_le_bytes(std::array::from_fn(|i| header[8 + i]));
    if ![ONE_VOLUME, VERSION].contains(&version) {
        let (found, expected) = (u64::from(version), u64::from(VERSION));
        return Err(KeepError::Version { path: path.to_owned(), found, expected });
    }
    if number(12) != generation {
        return Err(KeepError::malformed(path, "generation", number(12), generation.to_string()));
    }
    Ok((version, number(20).max(1)))
}

/// What stands where a record is expected.
enum Body {
    Whole,
    /// The file ends: no record, or one that was being written.
    Short,
    Damaged,
}

fn next_body(reader: &mut impl Read, left: u64, body: &mut Vec<u8>) -> std::io::Result<Body> {
    if left < RECORD_HEAD as u64 {
        return Ok(Body::Short);
    }
    let mut head = [0; RECORD_HEAD];
    reader.read_exact(&mut head)?;
    let length = u64::from(u32::from_le_bytes([head[0], head[1], head[2], head[3]]));
    if length > left - RECORD_HEAD as u64 {
        return Ok(Body::Short);
    }
    body.resize(length as usize, 0);
    reader.read_exact(body)?;
    Ok(if checksum(body) == head[4..] { Body::Whole } else { Body::Damaged })
}

/// Whether behind a record that cannot be read whole lies one that came later: then it is damaged, and not merely unfinished.
fn is_followed(reader: &mut BufReader<File>, at: u64, length: u64, sequence: u64) -> std::io::Result<bool> {
    let left = length - at;
    if left > MOST_UNFINISHED {
        return Ok(true);
    }
    let mut bytes = vec![0; left as usize];
    reader.seek(SeekFrom::Start(at))?;
    reader.read_exact(&mut bytes)?;
    // Bytes that only look like records must not take forever.
    let mut sums = bytes.len().saturating_mul(16);
    for from in 1..bytes.len() {
        let (head, body) = bytes[from..].split_at(RECORD_HEAD.min(bytes.len() - from));
        let (Some(size), Some(number)) = (head.first_chunk::<4>(), body.first_chunk::<8>()) else { break };
        let (size, number) = (u32::from_le_bytes(*size) as usize, u64::from_le_bytes(*number));
        let Some(body) = body.get(..size).filter(|_| number > sequence && number - sequence < MOST_AT_ONCE) else {
            continue;
        };
        if size > sums || checksum(body) == head[4..] {
            return Ok(true);
        }
        sums -= size;
    }
    Ok(false)
}

/// Whether a file was made and nothing was written into it: no step comes before the header.
fn is_unbegun(path: &Path, file: &File) -> Result<bool, KeepError> {
    file.metadata().map(|about| about.len() == 0).map_err(KeepError::io("read", path))
}

/// The folder and the name of a journal.
fn place(path: &Path) -> (&Path, String) {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    (path.parent().unwrap_or(Path::new("")), name)
}

/// Copies the journal before its end is cut off.
fn set_aside(path: &Path, what: String) -> Result<(PathBuf, String), KeepError> {
    let aside = free_aside(path);
    let (dir, name) = place(path);
    let copied = inside::open(dir, &name).and_then(|mut file| copy(&mut file, &aside));
    copied.map_err(KeepError::io("copy", path))?;
    Ok((aside, what))
}

/// Where a journal can be put aside without a loss of what was put there before.
pub(crate) fn free_aside(path: &Path) -> PathBuf {
    let names = (2..).map(|n| path.with_extension(format!("{n}.damaged")));
    let free = |path: &PathBuf| path.symlink_metadata().is_err_and(|e| e.kind() == ErrorKind::NotFound);
    std::iter::once(path.with_extension("damaged")).chain(names).find(free).unwrap_or_default()
}

fn copy(from: &mut File, to: &Path) -> std::io::Result<()> {
    let mut out = inside::create_anew(to)?;
    from.seek(SeekFrom::Start(0))?;
    std::io::copy(from, &mut out)?;
    out.sync_all()
}

/// What a record says apart from bricks; `None` if its head cannot be read.
fn read_head(record: &Record<'_>, old: bool, known: &Map<String, Value>, stroke: &mut SamplesHead) -> Option<StepHead> {
    match record.kind {
        Kind::Step | Kind::Checkpoint => {
            let head = match old {
                true => of_first_format(record.head, known)?,
                false => serde_json::from_slice::<StepHead>(record.head).ok()?,
            };
            if head.command.get("stroke").is_some() {
                stroke.samples.clear();
            }
            Some(head)
        }
        Kind::Samples => {
            let head: SamplesHead = serde_json::from_slice(record.head).ok()?;
            stroke.samples.extend(head.samples);
            (stroke.volume, stroke.also) = (head.volume, head.also);
            Some(StepHead::default())
        }
        Kind::NoStroke => {
            stroke.samples.clear();
            Some(StepHead::default())
        }
        Kind::Part => Some(StepHead::default()),
    }
}
