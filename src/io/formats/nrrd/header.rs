//! The text of a NRRD header: lines to fields, fields to lists of words, numbers and vectors.
//!
//! Definition of the NRRD file format (teem.sourceforge.net/nrrd/format.html), versions 1 to 5. What fields mean together is
//! `nrrd`'s.

use crate::io::codec::inflate::open_file;
use crate::io::error::IoError;
use crate::io::error::shown;
use crate::volume::VoxelType;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// No header is longer; as many segments as there can be, with names and places, take 40 megabytes.
const MAX_HEADER_BYTES: u64 = 64 << 20;

/// Most axes, as the format has it.
const MAX_AXES: usize = 16;

/// Unknown fields that are named; a hostile header may hold millions.
const MAX_UNKNOWN: usize = 10;

/// Fields whose spelling without a space is the same field.
const SPELLINGS: [(&str, &str); 11] = [
    ("datafile", "data file"),
    ("lineskip", "line skip"),
    ("byteskip", "byte skip"),
    ("blocksize", "block size"),
    ("oldmin", "old min"),
    ("oldmax", "old max"),
    ("axismins", "axis mins"),
    ("axismaxs", "axis maxs"),
    ("sampleunits", "sample units"),
    ("centerings", "centers"),
    ("spaceunits", "space units"),
];

/// Fields that are understood, or say nothing about where voxels are and what they are worth.
const FIELDS: [&str; 29] = [
    "dimension",
    "type",
    "encoding",
    "endian",
    "sizes",
    "spacings",
    "kinds",
    "units",
    "space",
    "space dimension",
    "space units",
    "space origin",
    "space directions",
    "data file",
    "line skip",
    "byte skip",
    "block size",
    "content",
    "number",
    "min",
    "max",
    "old min",
    "old max",
    "thicknesses",
    "axis mins",
    "axis maxs",
    "centers",
    "labels",
    "measurement frame",
];

/// Fields by their usual lower-case names.
#[derive(Debug)]
pub(crate) struct Header {
    pub(crate) file: String,
    fields: BTreeMap<String, String>,
    /// Free keys with their values, in the file's order.
    pub(crate) keys: Vec<(String, String)>,
    /// Names of data files that follow a header with a list of them.
    pub(crate) data_names: Vec<String>,
    /// Byte after the empty line that ends the header.
    pub(crate) end: u64,
    /// Number of axes, 1 to 16.
    pub(crate) dimension: usize,
}

impl Header {
    pub(crate) fn read(path: &Path, warnings: &mut Vec<String>) -> Result<Self, IoError> {
        let file = path.display().to_string();
        let wrong = |field: &str, found: &str, expected: &str| IoError::field(&file, field, found, expected);
        let mut lines = BufReader::new(open_file(path)?.take(MAX_HEADER_BYTES));
        let mut header = Self {
            file: file.clone(),
            fields: BTreeMap::new(),
            keys: Vec::new(),
            data_names: Vec::new(),
            end: 0,
            dimension: 0,
        };
        let mut lists = false;
        let mut line = Vec::new();
        for number in 1_u32.. {
            line.clear();
            let n = lines.read_until(b'\n', &mut line).map_err(IoError::system(path, "read the file"))?;
            header.end += n as u64;
            if header.end == MAX_HEADER_BYTES {
                return Err(wrong("header", "no empty line in 64 MiB", "an empty line between header and voxels"));
            }
            let text = String::from_utf8_lossy(&line);
            let text = text.trim_end_matches(['\n', '\r']);
            if number == 1 {
                let version = text.trim_end().strip_prefix("NRRD");
                if !version.is_some_and(|v| ["0001", "0002", "0003", "0004", "0005", "00.01"].contains(&v)) {
                    return Err(wrong(
                        "magic",
                        text,
                        "NRRD0001 to NRRD0005; unpack the file if it is compressed as a whole",
                    ));
                }
                continue;
            }
            // A detached header may just end.
            if n == 0 || (text.is_empty() && !lists) {
                break;
            }
            if lists {
                if !text.trim().is_empty() {
                    header.data_names.push(text.into());
                }
                continue;
            }
            header.line(text, number, warnings)?;
            let first = header.get("data file").and_then(|f| f.split_whitespace().next());
            lists = first.is_some_and(|word| word.eq_ignore_ascii_case("list"));
        }
        header.dimension = match header.number("dimension")? {
            Some(n @ 1..=16) => n as usize,
            Some(n) => return Err(wrong("dimension", &n.to_string(), &format!("1 to {MAX_AXES}"))),
            None => return Err(wrong("dimension", "", &format!("1 to {MAX_AXES}"))),
        };
        Ok(header)
    }

    fn line(&mut self, text: &str, number: u32, warnings: &mut Vec<String>) -> Result<(), IoError> {
        if text.starts_with('#') {
            return Ok(());
        }
        let Some((name, value)) = text.split_once(':') else {
            let expected = "`field: value`, `key:=value`, `# comment` or an empty line before the voxels";
            return Err(IoError::field(&self.file, format!("header line {number}"), text, expected));
        };
        if let Some(value) = value.strip_prefix('=') {
            self.keys.push((unescaped(name), unescaped(value)));
            return Ok(());
        }
        let name = name.trim().to_ascii_lowercase();
        let name = SPELLINGS.iter().find(|(other, _)| *other == name).map_or(name, |(_, usual)| (*usual).into());
        if !FIELDS.contains(&name.as_str()) && name != "sample units" {
            if warnings.len() < MAX_UNKNOWN {
                warnings.push(format!("header line {number}: field \"{}\" is not known and not used", shown(&name)));
            }
            return Ok(());
        }
        match self.fields.insert(name.clone(), value.trim().into()) {
            Some(before) if before != value.trim() => {
                let found = format!("\"{before}\" and then \"{}\"", value.trim());
                Err(IoError::field(&self.file, name, found, "the field once"))
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn get(&self, field: &str) -> Option<&str> {
        self.fields.get(field).map(String::as_str)
    }

    pub(crate) fn wrong(&self, field: &str, found: impl std::fmt::Display, expected: impl Into<String>) -> IoError {
        IoError::field(&self.file, field, found, expected)
    }

    pub(crate) fn number(&self, field: &str) -> Result<Option<i64>, IoError> {
        let Some(text) = self.get(field) else { return Ok(None) };
        text.parse().map(Some).map_err(|_| self.wrong(field, text, "a whole number"))
    }

    /// One word per axis; a word may be quoted.
    pub(crate) fn words(&self, field: &str) -> Result<Option<Vec<String>>, IoError> {
        let Some(text) = self.get(field) else { return Ok(None) };
        let mut words = Vec::new();
        let mut rest = text.trim_start();
        while !rest.is_empty() && words.len() <= MAX_AXES {
            let (word, after) = match rest.strip_prefix('"') {
                Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
                None => rest.split_once(char::is_whitespace).unwrap_or((rest, "")),
            };
            words.push(word.to_owned());
            rest = after.trim_start();
        }
        Ok(Some(words))
    }

    /// As `words`, one for each of `count` axes.
    pub(crate) fn words_for(&self, field: &str, count: usize) -> Result<Option<Vec<String>>, IoError> {
        match self.words(field)? {
            Some(words) if words.len() != count => {
                Err(self.wrong(field, format!("{} entries", words.len()), format!("{count}, one per axis")))
            }
            words => Ok(words),
        }
    }

    pub(crate) fn sizes(&self) -> Result<Vec<u64>, IoError> {
        let Some(words) = self.words_for("sizes", self.dimension)? else {
            return Err(self.wrong("sizes", "", format!("{} whole numbers", self.dimension)));
        };
        let size = |w: &String| match w.parse::<u64>() {
            Ok(n) if n > 0 => Ok(n),
            _ => Err(self.wrong("sizes", w, "whole numbers from 1 on")),
        };
        words.iter().map(size).collect()
    }

    /// Numbers per axis; what is not finite is `None`.
    pub(crate) fn spacings(&self) -> Result<Option<Vec<Option<f64>>>, IoError> {
        let Some(words) = self.words_for("spacings", self.dimension)? else { return Ok(None) };
        let number = |w: &String| match number(w) {
            Some(n) => Ok(Some(n).filter(|n: &f64| n.is_finite())),
            None => Err(self.wrong("spacings", w, "numbers")),
        };
        words.iter().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Vectors of `len` numbers, `(x,y,z)`, or `none`; spaces are allowed anywhere. A vector of NaN is none.
    pub(crate) fn vectors(&self, field: &str, len: usize) -> Result<Option<Vec<Option<Vec<f64>>>>, IoError> {
        let Some(text) = self.get(field) else { return Ok(None) };
        let expected = format!("vectors of {len} numbers like (1,0,0), or none");
        let mut vectors = Vec::new();
        let mut rest = text.trim_start();
        while !rest.is_empty() && vectors.len() <= MAX_AXES {
            if let Some(after) = rest.get(..4).filter(|w| w.eq_ignore_ascii_case("none")).map(|_| &rest[4..]) {
                vectors.push(None);
                rest = after.trim_start();
                continue;
            }
            let Some((inside, after)) = rest.strip_prefix('(').and_then(|r| r.split_once(')')) else {
                return Err(self.wrong(field, rest, expected));
            };
            let numbers: Option<Vec<f64>> = inside.split(',').map(number).collect();
            match numbers {
                Some(v) if v.len() == len && v.iter().all(|x| x.is_nan()) => vectors.push(None),
                Some(v) if v.len() == len && v.iter().all(|x| x.is_finite()) => vectors.push(Some(v)),
                _ => return Err(self.wrong(field, format!("({inside})"), expected)),
            }
            rest = after.trim_start();
        }
        Ok(Some(vectors))
    }

    pub(crate) fn voxel_type(&self) -> Result<VoxelType, IoError> {
        let found = self.get("type").unwrap_or_default();
        let name = found.split_whitespace().collect::<Vec<_>>().join(" ").to_ascii_lowercase();
        match name.as_str() {
            "signed char" | "int8" | "int8_t" => Ok(VoxelType::I8),
            "uchar" | "unsigned char" | "uint8" | "uint8_t" => Ok(VoxelType::U8),
            "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Ok(VoxelType::I16),
            "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Ok(VoxelType::U16),
            "int" | "signed int" | "int32" | "int32_t" => Ok(VoxelType::I32),
            "uint" | "unsigned int" | "uint32" | "uint32_t" => Ok(VoxelType::U32),
            "longlong"
            | "long long"
            | "long long int"
            | "signed long long"
            | "signed long long int"
            | "int64"
            | "int64_t" => Ok(VoxelType::I64),
            "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Ok(VoxelType::U64),
            "float" => Ok(VoxelType::F32),
            "double" => Ok(VoxelType::F64),
            _ => Err(self.wrong("type", found, "a number type such as uint8, short, int32, float or double")),
        }
    }
}

/// A key's text with `\n` and `\\` as the characters that they stand for.
fn unescaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        match (c, chars.clone().next()) {
            ('\\', Some('n')) => out.push('\n'),
            ('\\', Some('\\')) => out.push('\\'),
            _ => {
                out.push(c);
                continue;
            }
        }
        chars.next();
    }
    out
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok()
}
