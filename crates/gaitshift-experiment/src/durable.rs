//! Files that survive a kill at any moment: written beside the old one, and on the disk before they take its place.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Writes a file. Whoever looks, at any moment and after a loss of power too, finds the old content or the new one,
/// never a part.
///
/// # Errors
/// A file that cannot be written, or a disk that fails.
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".new");
    let beside = Path::new(&beside);
    let written = File::create(beside).and_then(|mut file| {
        file.write_all(content)?;
        file.sync_all()
    });
    if let Err(error) = written.and_then(|()| fs::rename(beside, path)) {
        let _ = fs::remove_file(beside);
        return Err(error);
    }
    sync_folder(path.parent().unwrap_or(Path::new("")))
}

/// Puts the names in a folder on the disk, and what every file in it holds.
///
/// # Errors
/// A file that cannot be opened for writing, or a disk that fails.
pub fn sync_files(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        // Writing is what some systems ask for before they sync.
        fs::OpenOptions::new()
            .write(true)
            .open(entry?.path())?
            .sync_all()?;
    }
    sync_folder(folder)
}

/// Puts the names in a folder on the disk.
///
/// # Errors
/// A folder that cannot be opened, or a disk that fails.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    let empty = folder.as_os_str().is_empty();
    File::open(if empty { Path::new(".") } else { folder })?.sync_all()
}

/// Elsewhere a folder cannot be opened, and the system keeps its names in order itself.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}
