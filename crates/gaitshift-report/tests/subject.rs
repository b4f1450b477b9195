//! Contract: a run is named after its experiment and seed, not after its folder; a controller without a run has none; what is not
//! there is an error that names it.

use crate::common;
use gaitshift_report::Subject;
use std::path::Path;

#[test]
fn a_run_is_named_after_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let run = common::run(folder.path());
    // Folders of several experiments are all called `seed-1`.
    let subject = Subject::read(&run).unwrap();
    assert_eq!(
        (subject.name.as_str(), subject.group.as_str(), subject.seed),
        ("paper, seed 7", "paper", 7)
    );
    assert_eq!(subject.run, Some(run.clone()));
    assert_eq!(subject.trained, None, "its configuration has no phases");
    let phases = "name = \"journal\"\nseed = 1\n[[curriculum.phases]]\nomega_v = [0.0, 1.0]\nomega_v_end = [-0.1, 1.0]\n\
                  [[curriculum.phases]]\nomega_v = [0.5, 2.5]\n";
    std::fs::write(run.join("config.toml"), phases).unwrap();
    assert_eq!(Subject::read(&run).unwrap().trained, Some([-0.1, 2.5]));
    std::fs::remove_file(run.join("config.toml")).unwrap();
    assert_eq!(Subject::read(&run).unwrap().run, None);
}

#[test]
fn what_is_not_there_is_named() {
    let missing = Subject::read(Path::new("no/such/run"))
        .unwrap_err()
        .to_string();
    assert!(missing.contains("no/such/run"), "{missing}");
}
