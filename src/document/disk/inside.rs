//! Files inside a project's folder: regular files in real folders, nothing else.
//!
//! The way to a project may lead over symbolic links; nothing in it is followed out of it, neither to read nor to write, and what
//! is no regular file is refused by name before it can hold the program. `root` is the project's (or a generation's) folder, `name`
//! is relative to it, with slashes. Owns the looking; knows no format.

use crate::document::disk::error::KeepError;
use crate::io::regular::{kind, must_be_regular, read_up_to};
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};
use zarrs::storage::byte_range::{ByteRange, ByteRangeIterator};
use zarrs::storage::{Bytes, MaybeBytesIterator, ReadableStorageTraits, StorageError, StoreKey};

/// Opens a file for reading.
pub(crate) fn open(root: &Path, name: &str) -> Result<File> {
    open_with(root, name, OpenOptions::new().read(true))
}

/// Opens a file for reading and writing.
pub(crate) fn open_to_write(root: &Path, name: &str) -> Result<File> {
    open_with(root, name, OpenOptions::new().read(true).write(true))
}

/// The same; an empty one is made if there is none.
pub(crate) fn open_or_create(root: &Path, name: &str) -> Result<File> {
    open_with(root, name, OpenOptions::new().read(true).write(true).create(true).truncate(false))
}

/// A new file for reading and writing in the place of what may be there, which is not written to; a folder stays.
pub(crate) fn create_anew(path: &Path) -> Result<File> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    OpenOptions::new().read(true).write(true).create_new(true).open(path)
}

/// All of a file, but at most `most` bytes.
pub(crate) fn read(root: &Path, name: &str, most: u64) -> std::result::Result<Vec<u8>, KeepError> {
    open(root, name).and_then(|file| read_up_to(file, most)).map_err(KeepError::io("read", &root.join(name)))
}

/// Fails unless there is a regular file, reached through real folders.
pub(crate) fn check_file(root: &Path, name: &str) -> Result<PathBuf> {
    let path = check_way(root, name)?;
    must_be_regular(&std::fs::symlink_metadata(&path)?)?;
    Ok(path)
}

/// Fails unless `path` is a folder itself and not a link to one.
pub(crate) fn check_folder(path: &Path) -> std::result::Result<(), KeepError> {
    real_folder(path).map_err(KeepError::io("read", path))
}

fn real_folder(path: &Path) -> Result<()> {
    let about = std::fs::symlink_metadata(path)?;
    match about.is_dir() {
        true => Ok(()),
        false => Err(Error::new(ErrorKind::InvalidInput, format!("{} found, a folder expected", kind(&about)))),
    }
}

/// The file's path, once every folder between is known for one.
fn check_way(root: &Path, name: &str) -> Result<PathBuf> {
    let mut path = root.to_owned();
    let mut parts = name.split('/').peekable();
    while let Some(part) = parts.next() {
        path.push(part);
        if parts.peek().is_some() {
            real_folder(&path)?;
        }
    }
    Ok(path)
}

fn open_with(root: &Path, name: &str, options: &mut OpenOptions) -> Result<File> {
    let path = check_way(root, name)?;
    match std::fs::symlink_metadata(&path) {
        Ok(about) => must_be_regular(&about)?,
        // What makes files says so itself.
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    let file = without_following(options).open(&path)?;
    must_be_regular(&file.metadata()?)?;
    Ok(file)
}

/// So that a link that came in between is not followed either.
fn without_following(options: &mut OpenOptions) -> &mut OpenOptions {
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY;
        std::os::unix::fs::OpenOptionsExt::custom_flags(options, flags.bits() as i32)
    }
    #[cfg(not(unix))]
    crate::io::regular::without_waiting(options)
}

/// Whether a file has other names, so that to write into it would change what lies elsewhere.
pub(crate) fn has_other_names(file: &File) -> Result<bool> {
    #[cfg(unix)]
    return Ok(std::os::unix::fs::MetadataExt::nlink(&file.metadata()?) > 1);
    #[cfg(not(unix))]
    return file.metadata().map(|_| false);
}

/// Fails if nobody may write in a folder, whoever asks: a superuser would be let.
pub(crate) fn check_writable(dir: &Path) -> Result<()> {
    match std::fs::metadata(dir)?.permissions().readonly() {
        true => Err(Error::new(ErrorKind::PermissionDenied, "the folder is write-protected")),
        false => Ok(()),
    }
}

/// A generation's folder as zarrs reads it. What is missing is an error and no empty chunk.
#[derive(Debug)]
pub(crate) struct Files(pub PathBuf);

impl Files {
    fn open(&self, key: &StoreKey) -> std::result::Result<(File, u64), StorageError> {
        let file = open(&self.0, key.as_str())?;
        let length = file.metadata()?.len();
        Ok((file, length))
    }
}

impl ReadableStorageTraits for Files {
    fn get_partial_many<'a>(
        &'a self,
        key: &StoreKey,
        ranges: ByteRangeIterator<'a>,
    ) -> std::result::Result<MaybeBytesIterator<'a>, StorageError> {
        let (file, length) = self.open(key)?;
        let read = move |range: ByteRange| {
            // Numbers of a damaged index may be any: their sums may be beyond all numbers.
            let beyond = || StorageError::Other(format!("more bytes asked for than the {length} that are there"));
            let (start, count) = match range {
                ByteRange::FromStart(start, Some(count)) => (start, count),
                ByteRange::FromStart(start, None) => (start, length.checked_sub(start).ok_or_else(beyond)?),
                ByteRange::Suffix(count) => (length.checked_sub(count).ok_or_else(beyond)?, count),
            };
            let inside = start.checked_add(count).is_some_and(|end| end <= length);
            let mut bytes = vec![0; usize::try_from(count).ok().filter(|_| inside).ok_or_else(beyond)?];
            crate::io::regular::read_exact_at(&file, &mut bytes, start)?;
            Ok(Bytes::from(bytes))
        };
        Ok(Some(Box::new(ranges.map(read))))
    }

    fn size_key(&self, key: &StoreKey) -> std::result::Result<Option<u64>, StorageError> {
        Ok(Some(self.open(key)?.1))
    }

    fn supports_get_partial(&self) -> bool {
        true
    }
}
