//! Contract: a file is written whole or stays as it was, nothing is left beside it, and a link keeps leading where it led; a name that
//! is taken is told from other causes.

use gaitshift_analysis::{name_taken, write_whole};
use std::fs;

fn names(folder: &std::path::Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = names
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_and_nothing_is_left_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("motion.csv");
    for content in ["first", "second"] {
        write_whole(&file, content.as_bytes()).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), content);
        assert_eq!(names(folder.path()), ["motion.csv"]);
    }
}

// A full disk left half of the new recording in the place of the old one.
#[test]
fn what_cannot_be_written_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("motion.csv");
    write_whole(&file, b"old").unwrap();
    // Where the new content would be written, a folder is in the way.
    fs::create_dir(folder.path().join("motion.csv.new")).unwrap();
    assert!(write_whole(&file, b"new").is_err());
    assert_eq!(fs::read(&file).unwrap(), b"old");
    assert!(write_whole(&folder.path().join("no/motion.csv"), b"new").is_err());
}

#[cfg(unix)]
#[test]
fn a_link_leads_where_it_led() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    write_whole(&file, b"old").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    write_whole(&link, b"new").unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
}

#[test]
fn a_name_that_is_taken_is_told_from_what_else_keeps_a_file_from_being_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    write_whole(&file, b"in the way").unwrap();
    let below = std::fs::create_dir_all(file.join("out")).unwrap_err();
    let itself = std::fs::create_dir_all(&file).unwrap_err();
    for cause in [below, itself] {
        assert!(name_taken(&cause).unwrap().contains("a file is where"));
    }
    let on_a_folder = write_whole(folder.path(), b"").unwrap_err();
    assert!(name_taken(&on_a_folder).unwrap().contains("it is a folder"));
    let missing = write_whole(&folder.path().join("no/file"), b"").unwrap_err();
    assert_eq!(name_taken(&missing), None);
}
