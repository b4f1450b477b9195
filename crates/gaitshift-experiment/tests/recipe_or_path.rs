//! Contract: a text that names an experiment is a recipe's name, or a path, and looks like what it is. A file of its own,
//! since it changes the working directory, which belongs to the whole process.

use gaitshift_experiment::Experiment;

#[test]
fn a_folder_named_like_a_recipe_does_not_hide_the_recipe() {
    // What went wrong: a folder called `paper` or `fast` in the working directory was taken for the file that was asked
    // for: "Is a directory".
    let folder = tempfile::tempdir().unwrap();
    for name in ["paper", "fast", "mine"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    std::fs::write(folder.path().join("bare"), "seed = 7").unwrap();
    let before = std::env::current_dir().unwrap();
    std::env::set_current_dir(folder.path()).unwrap();
    let load = |text: &str| Experiment::load(text).map_err(|e| e.to_string());
    let (paper, fast, mine) = (load("paper"), load("fast"), load("mine"));
    let (bare, slashed) = (load("bare"), load("./bare"));
    let directory = load("./fast");
    std::env::set_current_dir(before).unwrap();
    assert_eq!(paper.unwrap().name, "paper");
    assert_eq!(fast.unwrap().name, "fast");
    assert!(mine.unwrap_err().contains("recipe `mine`"));
    // A path is a path only when it looks like one, and the error says how.
    assert!(bare.unwrap_err().contains("./bare"));
    assert_eq!(slashed.unwrap().seed, 7);
    assert!(directory.unwrap_err().contains("./fast"));
}
