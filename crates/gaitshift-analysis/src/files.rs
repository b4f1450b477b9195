//! Files that are whole or not there.

use std::fs;
use std::io;
use std::path::Path;

/// What to do where a file or folder cannot be written because its name is taken by the other; `None` of any other cause.
pub fn name_taken(cause: &io::Error) -> Option<&'static str> {
    match cause.kind() {
        io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory => {
            Some("a file is where a folder is to be; give another --out")
        }
        io::ErrorKind::IsADirectory => Some("it is a folder; remove it, or give another --out"),
        _ => None,
    }
}

/// Writes a file beside its place and puts it there when it is whole: if it cannot be written, as on a full disk, what was there
/// before stays. What is no ordinary file, such as a device or a link, is written in place.
///
/// # Errors
/// A file that cannot be written.
pub fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    if fs::symlink_metadata(path).is_ok_and(|there| !there.is_file()) {
        return fs::write(path, content);
    }
    let mut beside = path.as_os_str().to_owned();
    beside.push(".new");
    let beside = Path::new(&beside);
    let written = fs::write(beside, content).and_then(|()| fs::rename(beside, path));
    if written.is_err() {
        let _ = fs::remove_file(beside);
    }
    written
}
