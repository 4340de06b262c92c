//! Which files hold the voxels of a NRRD header: itself, another one, or a series by list or by pattern.
//!
//! Field `data file` of teem's definition, with the number of axes that each file of a series has. A header must not make anyone
//! read what lies elsewhere: names lead into its own folder or below.

use crate::io::error::IoError;
use crate::io::formats::nrrd::header::Header;
use std::path::{Component, Path, PathBuf};

/// Digits that a number in a file's name may be filled up to.
const MOST_DIGITS: usize = 64;

/// The files in order; `None`: the header's own, behind it.
pub(crate) fn data_files(path: &Path, header: &Header, sizes: &[u64]) -> Result<Option<Vec<PathBuf>>, IoError> {
    let Some(field) = header.get("data file") else { return Ok(None) };
    let words: Vec<&str> = field.split_whitespace().collect();
    if let Some((list, subdim)) = words.split_first().filter(|(w, _)| w.eq_ignore_ascii_case("list")) {
        let needed = needed(header, &format!("{list} {}", subdim.join(" ")), subdim, sizes)?;
        let names = &header.data_names;
        if names.len() as u64 != needed {
            let found = format!("{list} of {} files", names.len());
            return Err(header.wrong("data file", found, format!("{needed}, one for each part of sizes {sizes:?}")));
        }
        return names.iter().map(|name| beside(path, header, name)).collect::<Result<_, _>>().map(Some);
    }
    match Pattern::of(field) {
        Some(Ok(pattern)) => {
            let needed = needed(header, field, &words[pattern.words..], sizes)?;
            if pattern.count() != Some(needed) {
                let count = pattern.count().map_or("no end of".into(), |n| n.to_string());
                let expected = format!("{needed} files, one for each part of sizes {sizes:?}");
                return Err(header.wrong("data file", format!("{field} ({count} files)"), expected));
            }
            // One by one, so that the first that is not there ends it.
            (0..needed).map(|n| beside(path, header, &pattern.name(n))).collect::<Result<_, _>>().map(Some)
        }
        Some(Err(expected)) => Err(header.wrong("data file", field, expected)),
        None => Ok(Some(vec![beside(path, header, field)?])),
    }
}

/// How many files a series has: one for each part of the axes beyond those that each file has, or if each has all of them, as many
/// as the last axis can be cut into equally.
fn needed(header: &Header, field: &str, subdim: &[&str], sizes: &[u64]) -> Result<u64, IoError> {
    let n = sizes.len();
    let expected = format!("at the end nothing, or 1 to {n}: the number of axes that each file has");
    let axes = match subdim {
        [] if n == 1 => 1,
        [] => n - 1,
        [word] => word
            .parse()
            .ok()
            .filter(|d| (1..=n).contains(d))
            .ok_or_else(|| header.wrong("data file", field, expected))?,
        _ => return Err(header.wrong("data file", field, expected)),
    };
    if axes < n {
        let files = sizes[axes..].iter().try_fold(1_u64, |n, &s| n.checked_mul(s));
        return files.ok_or_else(|| header.wrong("sizes", format!("{sizes:?}"), "less than 2^64 files"));
    }
    let files = match Pattern::of(header.get("data file").unwrap_or_default()) {
        Some(Ok(pattern)) => pattern.count().unwrap_or(0),
        _ => header.data_names.len() as u64,
    };
    if !sizes[n - 1].is_multiple_of(files) {
        let expected = format!("a number of files that divides the last of sizes {sizes:?}");
        return Err(header.wrong("data file", format!("{files} files"), expected));
    }
    Ok(files)
}

/// The file of a name, which is inside the header's folder.
fn beside(path: &Path, header: &Header, name: &str) -> Result<PathBuf, IoError> {
    let name = Path::new(name);
    let inside = name.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if !inside || name.file_name().is_none() {
        return Err(header.wrong("data file", name.display(), "a file in the header's own folder or below"));
    }
    let data = path.parent().unwrap_or(Path::new("")).join(name);
    if data.is_file() {
        Ok(data)
    } else {
        Err(header.wrong("data file", name.display(), format!("a file; there is none at {}", data.display())))
    }
}

/// `name%03d.raw 1 20 1`: a number in a name, from first to last by step.
#[derive(Debug)]
struct Pattern {
    before: String,
    after: String,
    /// Least number of characters, and what fills up to it.
    width: usize,
    zeros: bool,
    /// Least number of digits.
    digits: usize,
    first: i64,
    last: i64,
    step: i64,
    /// Words of the field that are the pattern's.
    words: usize,
}

impl Pattern {
    /// `None` if the field is the name of one file.
    fn of(field: &str) -> Option<Result<Self, String>> {
        let words: Vec<&str> = field.split_whitespace().collect();
        let name = *words.first()?;
        let (before, rest) = split_at_number(name)?;
        let expected = || {
            "a pattern like name%03d.raw with first, last and step behind it, e.g. name%03d.raw 1 20 1; \
             or one file whose name holds no number pattern"
                .to_owned()
        };
        let flags: String = rest.chars().take_while(|c| "0-+ #".contains(*c)).collect();
        let width: String = rest[flags.len()..].chars().take_while(char::is_ascii_digit).collect();
        let rest = &rest[flags.len() + width.len()..];
        let precision: Option<String> =
            rest.strip_prefix('.').map(|r| r.chars().take_while(char::is_ascii_digit).collect());
        let rest = &rest[precision.as_ref().map_or(0, |p| p.len() + 1)..];
        let number = |text: &str| match text {
            "" => Some(0),
            text => text.parse::<usize>().ok().filter(|&n| n <= MOST_DIGITS),
        };
        let (Some(width), Some(digits)) = (number(&width), number(precision.as_deref().unwrap_or("1"))) else {
            return Some(Err(format!("at most {MOST_DIGITS} digits in a name's number")));
        };
        let Some(after) = rest.strip_prefix(['d', 'i', 'u']) else { return Some(Err(expected())) };
        if !flags.chars().all(|c| c == '0') || split_at_number(after).is_some() {
            return Some(Err(expected()));
        }
        let range: Option<Vec<i64>> = words.get(1..4).and_then(|w| w.iter().map(|n| n.parse().ok()).collect());
        let Some([first, last, step]) = range.as_deref().and_then(|r| r.first_chunk::<3>()).copied() else {
            return Some(Err(expected()));
        };
        // C: a precision takes the zero flag's meaning away.
        let zeros = flags.contains('0') && precision.is_none();
        let (before, after) = (before.replace("%%", "%"), after.replace("%%", "%"));
        Some(Ok(Self { before, after, width, zeros, digits, first, last, step, words: 4 }))
    }

    /// `None` if the last number is never reached.
    fn count(&self) -> Option<u64> {
        let (first, last, step) = (i128::from(self.first), i128::from(self.last), i128::from(self.step));
        let runs = step != 0 && (last - first).signum() * step.signum() >= 0;
        runs.then(|| u64::try_from((last - first) / step + 1).ok()).flatten()
    }

    fn name(&self, n: u64) -> String {
        let number = i128::from(self.first) + i128::from(n) * i128::from(self.step);
        let digits = format!("{:0>1$}", number.unsigned_abs(), self.digits);
        let sign = if number < 0 { "-" } else { "" };
        let room = self.width.saturating_sub(sign.len());
        let text = if self.zeros { format!("{sign}{digits:0>room$}") } else { format!("{sign}{digits}") };
        format!("{}{text:>2$}{}", self.before, self.after, self.width)
    }
}

/// The name before its first `%` that is not doubled, and after it.
fn split_at_number(name: &str) -> Option<(&str, &str)> {
    let mut from = 0;
    loop {
        let at = from + name[from..].find('%')?;
        if !name[at + 1..].starts_with('%') {
            return Some((&name[..at], &name[at + 1..]));
        }
        from = at + 2;
    }
}
