//! Key files: 32 random bytes that nobody but their owner may read.

use crate::authenticity::{KEY_BYTES, Key, Keyring};
use rustix::process::geteuid;
use rustix::rand::{GetRandomFlags, getrandom};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a key file is not used, or not written.
#[derive(Debug, Error)]
pub enum KeyFileError {
    /// It can't be read or written.
    #[error(
        "key file {path}: {source}; `touchdown keygen FILE` writes a new one, and copies of it go to all hosts of the cell"
    )]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is a directory, a device, a pipe.
    #[error("key file {path} is no regular file; name one that `touchdown keygen` has written")]
    Kind {
        /// The file.
        path: PathBuf,
    },
    /// Others may read it.
    #[error(
        "key file {path} has mode {mode:04o}, but nobody else may read it (0600); `chmod 600 {path}`, and write a new \
             key if somebody has"
    )]
    Mode {
        /// The file.
        path: PathBuf,
        /// Its permissions.
        mode: u32,
    },
    /// It belongs to somebody else.
    #[error(
        "key file {path} belongs to user {found}, but this process is of user {expected}; `chown {expected} {path}`"
    )]
    Owner {
        /// The file.
        path: PathBuf,
        /// Whose it is.
        found: u32,
        /// Whose it should be.
        expected: u32,
    },
    /// It has another size.
    #[error(
        "key file {path} has {found} bytes, but a key has {KEY_BYTES}; `touchdown keygen FILE` writes one"
    )]
    Length {
        /// The file.
        path: PathBuf,
        /// Its bytes.
        found: u64,
    },
    /// There is one already.
    #[error(
        "{path} is there already and is not overwritten; name another file, or remove it where no node uses it any more"
    )]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The kernel gives no random bytes.
    #[error("no random bytes: {0}")]
    Random(#[from] rustix::io::Errno),
}

/// 32 bytes of the kernel's randomness.
pub fn draw_secret() -> Result<[u8; KEY_BYTES], KeyFileError> {
    let mut secret = [0; KEY_BYTES];
    // Up to 256 bytes come as a whole.
    getrandom(&mut secret, GetRandomFlags::empty())?;
    Ok(secret)
}

/// The keys in `files`, the first of which signs; `None`: no file is named.
pub fn read_all(files: &[PathBuf]) -> Result<Option<Keyring>, KeyFileError> {
    let mut keys = files.iter().map(|path| read(path));
    let Some(first) = keys.next().transpose()? else {
        return Ok(None);
    };
    Ok(Some(Keyring::new(first, keys.collect::<Result<_, _>>()?)))
}

/// The key in the file at `path`.
pub fn read(path: &Path) -> Result<Key, KeyFileError> {
    let path = path.to_owned();
    let failed = |source| {
        let path = path.clone();
        KeyFileError::Io { path, source }
    };
    // Opening a pipe would wait for its other end.
    if !fs::metadata(&path).map_err(failed)?.is_file() {
        return Err(KeyFileError::Kind { path });
    }
    let mut file = File::open(&path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    let (mode, found, expected) = (metadata.mode() & 0o7777, metadata.uid(), geteuid().as_raw());
    if mode & 0o177 != 0 {
        return Err(KeyFileError::Mode { path, mode });
    }
    if found != expected {
        return Err(KeyFileError::Owner {
            path,
            found,
            expected,
        });
    }
    if metadata.len() != KEY_BYTES as u64 {
        let found = metadata.len();
        return Err(KeyFileError::Length { path, found });
    }
    let mut secret = [0; KEY_BYTES];
    file.read_exact(&mut secret).map_err(failed)?;
    Ok(Key::new(&secret))
}

/// Write a new key to `path`, where there is nothing yet.
pub fn create(path: &Path) -> Result<Key, KeyFileError> {
    let secret = draw_secret()?;
    let mut options = OpenOptions::new();
    let file = options.write(true).create_new(true).mode(0o600).open(path);
    let failed = |source: io::Error| {
        let path = path.to_owned();
        match source.kind() {
            io::ErrorKind::AlreadyExists => KeyFileError::Exists { path },
            _ => KeyFileError::Io { path, source },
        }
    };
    let mut file = file.map_err(failed)?;
    let written = file.write_all(&secret).and_then(|()| file.sync_all());
    if written.is_err() {
        // Half a key is none.
        let _ = fs::remove_file(path);
    }
    written.map_err(failed)?;
    Ok(Key::new(&secret))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_key_is_read_as_it_was_written_and_never_overwritten() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("cell.key");
        let key = create(&path).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o7777, 0o600);
        assert_eq!(read(&path).unwrap().id(), key.id());
        assert!(matches!(create(&path), Err(KeyFileError::Exists { .. })));
        assert_eq!(read(&path).unwrap().id(), key.id());
        let other = create(&directory.path().join("other.key")).unwrap();
        assert_ne!(other.id(), key.id());
    }

    #[test]
    fn what_others_can_read_or_is_no_key_is_refused_with_a_remedy() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("cell.key");
        let refused = |path: &Path| read(path).unwrap_err().to_string();
        assert!(refused(&path).contains("keygen"), "{}", refused(&path));
        assert!(refused(directory.path()).contains("no regular file"));
        create(&path).unwrap();
        for mode in [0o640, 0o604, 0o666, 0o700, 0o620] {
            fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
            let text = refused(&path);
            assert!(
                text.contains(&format!("mode {mode:04o}")) && text.contains("chmod 600"),
                "{text}"
            );
        }
        fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
        for bytes in [0, 31, 33] {
            fs::write(&path, vec![1; bytes]).unwrap();
            assert!(
                refused(&path).contains(&format!("has {bytes} bytes")),
                "{}",
                refused(&path)
            );
        }
    }
}
