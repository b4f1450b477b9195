//! Files that are whole or not there.

use std::fs;
use std::io;
use std::path::Path;

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
