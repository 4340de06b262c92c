//! What the system refused, in words for a person.
//!
//! The system's own sentences end in numbers and speak of files where folders are meant; whatever is shown to a user passes here.

use std::io::{Error, ErrorKind};

/// The reason in plain words, without the system's number: a clause that follows a colon.
pub fn in_words(error: &Error) -> String {
    let known = match error.kind() {
        ErrorKind::NotFound => "it is not there",
        ErrorKind::PermissionDenied => "the system does not allow it for this user",
        ErrorKind::AlreadyExists => "something of that name is there already",
        ErrorKind::StorageFull => "the disk is full",
        ErrorKind::QuotaExceeded => "this user's share of the disk is full",
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only",
        ErrorKind::FileTooLarge => "the disk holds no file of that size",
        ErrorKind::IsADirectory => "a folder is there, not a file",
        ErrorKind::NotADirectory => "a file is there where a folder should be",
        ErrorKind::DirectoryNotEmpty => "the folder is not empty",
        ErrorKind::InvalidFilename => "the disk allows no such name",
        ErrorKind::OutOfMemory => "there is too little memory",
        ErrorKind::TimedOut | ErrorKind::HostUnreachable | ErrorKind::NetworkUnreachable => {
            "the network does not answer"
        }
        ErrorKind::StaleNetworkFileHandle => "the network folder has changed; open it anew",
        ErrorKind::ResourceBusy | ErrorKind::ExecutableFileBusy => "another program is using it",
        ErrorKind::CrossesDevices => "it lies on another disk",
        ErrorKind::TooManyLinks => "there are too many links",
        ErrorKind::UnexpectedEof => "it ends too early",
        _ => "",
    };
    // A text of this program's own says more than its kind does.
    match (error.raw_os_error(), known) {
        (Some(_), known) if !known.is_empty() => known.to_owned(),
        (None, known) if error.get_ref().is_none() && !known.is_empty() => known.to_owned(),
        _ => without_numbers(&error.to_string()),
    }
}

/// A sentence without the numbers that the system puts behind its own.
pub fn without_numbers(text: &str) -> String {
    const MARK: &str = " (os error ";
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(MARK) {
        let behind = &rest[at + MARK.len()..];
        let digits = behind.trim_start_matches('-').trim_start_matches(|c: char| c.is_ascii_digit());
        match digits.strip_prefix(')') {
            Some(after) => {
                out.push_str(&rest[..at]);
                rest = after;
            }
            None => {
                out.push_str(&rest[..at + MARK.len()]);
                rest = behind;
            }
        }
    }
    out.push_str(rest);
    out
}
