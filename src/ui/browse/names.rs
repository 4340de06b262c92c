//! Names and paths between what a person types and reads and what the system has: any bytes, any length.

use crate::interact::readout;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// What was typed or pasted, as a path: absolute, from the folder that is shown, from home (`~`), or a `file://` address.
///
/// # Errors
/// A sentence, if it means no place.
pub fn resolve(text: &str, folder: &Path, home: Option<&Path>) -> Result<PathBuf, String> {
    // A name may begin or end in blanks: as it stands if that is there.
    let exact = folder.join(text);
    if !text.is_empty() && exact.symlink_metadata().is_ok() {
        return Ok(tidy(&exact));
    }
    let text = text.trim();
    let quoted = ['"', '\''].iter().find_map(|&q| text.strip_prefix(q)?.strip_suffix(q));
    let text = quoted.unwrap_or(text);
    if text.is_empty() {
        return Err("Type a name.".into());
    }
    if text.contains('\0') {
        return Err("A name cannot hold this character.".into());
    }
    if let Some(address) = text.strip_prefix("file://") {
        // Between the slashes may stand a machine's name; of this one only.
        let path = address.strip_prefix("localhost").unwrap_or(address);
        return if path.starts_with('/') {
            Ok(PathBuf::from(decoded(path)))
        } else {
            Err("This address lies on another machine. Choose a file on this one.".into())
        };
    }
    if let Some(rest) = text.strip_prefix('~') {
        return match (home, rest.strip_prefix('/')) {
            (Some(home), _) if rest.is_empty() => Ok(home.to_path_buf()),
            (Some(home), Some(rest)) => Ok(home.join(rest.trim_start_matches('/'))),
            (None, _) => Err("No home folder is known here. Type the whole path.".into()),
            (Some(_), None) => Err(format!("“~{rest}” is not known here. Type the whole path.")),
        };
    }
    Ok(tidy(&folder.join(text)))
}

/// A path without `.` and, where that cannot lead through a link, without `..`.
fn tidy(path: &Path) -> PathBuf {
    let dots = path.components().any(|c| c == std::path::Component::ParentDir);
    if dots && let Ok(whole) = path.canonicalize() {
        return whole;
    }
    path.components().collect()
}

/// `%20` and the like as the bytes that they stand for.
fn decoded(text: &str) -> OsString {
    let bytes = text.as_bytes();
    let (mut out, mut i) = (Vec::with_capacity(bytes.len()), 0);
    while i < bytes.len() {
        let code = (bytes[i] == b'%').then(|| text.get(i + 1..i + 3)).flatten();
        match code.and_then(|c| u8::from_str_radix(c, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    os_string(out)
}

#[cfg(unix)]
fn os_string(bytes: Vec<u8>) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes)
}

#[cfg(not(unix))]
fn os_string(bytes: Vec<u8>) -> OsString {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// A name or path as it is shown: what is no text becomes �, what would break the line is escaped.
pub fn shown(name: &OsStr) -> String {
    let mut out = String::new();
    for c in name.to_string_lossy().chars() {
        if c.is_control() { out.extend(c.escape_debug()) } else { out.push(c) }
    }
    out
}

/// Whether a name has one of the endings, in capitals or not.
pub fn ends_with(name: &OsStr, endings: &[&str]) -> bool {
    let name = name.as_encoded_bytes();
    endings.iter().any(|ending| {
        let n = ending.len();
        name.len() > n && name[name.len() - n..].eq_ignore_ascii_case(ending.as_bytes())
    })
}

/// A path with the first of the endings, if it has none of them.
pub fn with_ending(path: PathBuf, endings: &[&str]) -> PathBuf {
    match (endings.first(), path.file_name()) {
        (Some(ending), Some(name)) if !ends_with(name, endings) => {
            let mut name = name.to_owned();
            name.push(ending);
            path.with_file_name(name)
        }
        _ => path,
    }
}

/// What names are compared by: without capitals, numbers by their value.
pub(super) fn in_order(name: &OsStr) -> String {
    let name = name.to_string_lossy().to_lowercase();
    let mut key = String::with_capacity(name.len() + 16);
    let mut rest = name.as_str();
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        key.push_str(&rest[..at]);
        let end = rest[at..].find(|c: char| !c.is_ascii_digit()).map_or(rest.len(), |n| at + n);
        let digits = rest[at..end].trim_start_matches('0');
        // A number with more digits is the larger one.
        key.push_str(&format!("{:03}{digits}", digits.len().min(999)));
        rest = &rest[end..];
    }
    key.push_str(rest);
    key
}

/// When something was: how long ago within a day, else the date.
pub fn date(at: SystemTime, now: SystemTime) -> String {
    const DAY: Duration = Duration::from_secs(86_400);
    match now.duration_since(at) {
        Ok(since) if since < DAY => readout::ago(since.as_secs()),
        _ => {
            let days = match at.duration_since(UNIX_EPOCH) {
                Ok(since) => (since.as_secs() / DAY.as_secs()) as i64,
                Err(before) => -(before.duration().as_secs().div_ceil(DAY.as_secs()) as i64),
            };
            let (year, month, day) = civil(days);
            format!("{year:04}-{month:02}-{day:02}")
        }
    }
}

/// Year, month and day of a number of days since 1970-01-01: years are counted from March, so that the leap day is their last.
fn civil(days: i64) -> (i64, i64, i64) {
    // From 0000-03-01; 400 years have 146,097 days.
    let days = days + 719_468;
    let (era, day) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // Months of 31, 30, 31, 30, 31 days: 153 in five.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    (year + era * 400 + i64::from(month <= 2), month, day)
}
