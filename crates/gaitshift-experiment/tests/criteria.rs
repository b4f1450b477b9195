//! Contract: without a word on it an experiment is judged by the paper's 39 criteria; `[criteria]` replaces what it names, in
//! an experiment or a file of its own; nonsense is answered by its key and what would do; a run keeps the criteria by which
//! its best controller was chosen.

use crate::common::{TINY, Until, text, tiny};
use gaitshift_analysis::GaitClass;
use gaitshift_experiment::{
    AskedChange, AskedGait, Criteria, Evaluation, Experiment, RECIPES, Training,
};

const MINE: &str = "[criteria]\nomega_v = [0, 2]\nduration_s = 8\nslowest_froude_max = 0\nfastest_froude_min = 0.6\n\
    [[criteria.gaits]]\nomega_v = 0\ngait = \"walking\"\nfroude_min = 0.1\nfroude_max = 0.3\n\
    [[criteria.gaits]]\nomega_v = 2\ngait = \"running\"\n\
    [[criteria.changes]]\nfrom = 0\nto = 2\nphases = 2\n";

fn mine() -> Criteria {
    Criteria {
        omega_v: vec![0.0, 2.0],
        duration_s: 8.0,
        slowest_froude_max: 0.0,
        fastest_froude_min: 0.6,
        gaits: vec![
            AskedGait {
                froude_min: 0.1,
                froude_max: 0.3,
                ..AskedGait::new(0.0, GaitClass::Walking)
            },
            AskedGait::new(2.0, GaitClass::Running),
        ],
        changes: vec![AskedChange {
            phases: 2,
            ..AskedChange::new(0.0, 2.0)
        }],
    }
}

#[test]
fn recipes_ask_for_what_the_paper_reports() {
    let asked = |name| Experiment::recipe(name).unwrap().criteria;
    let paper = Criteria::default();
    for (name, _) in RECIPES.into_iter().filter(|(name, _)| *name != "journal") {
        assert_eq!(asked(name), paper, "{name}");
    }
    // Trained with commands up to 2.5, where it therefore has to run; two commands fewer.
    let journal = asked("journal");
    assert_eq!(journal.count(), 37);
    assert_eq!(journal.first(GaitClass::Running).unwrap().omega_v, 2.5);
    assert_eq!(journal.fastest_froude_min, paper.fastest_froude_min);
    assert_eq!(paper.count(), 39);
    assert_eq!(
        paper.to_string(),
        "39 criteria: 8 commands from 0 to 3.5, walking at 0, running at 3, 0 -> 3, 3 -> 0"
    );
}

#[test]
fn criteria_of_ones_own_stand_in_an_experiment_or_a_file() {
    let experiment = Experiment::parse(&format!("base = \"fast\"\n{MINE}"), "mine.toml").unwrap();
    assert_eq!(experiment.criteria, mine());
    assert_eq!(mine().count(), 2 + 3 + 1 + 1 + 2);
    // What is resolved says the same.
    let again = Experiment::parse(&experiment.to_toml().unwrap(), "config.toml").unwrap();
    assert_eq!(again.criteria, mine());
    // One key alone leaves the others.
    let longer = experiment
        .with_values(&["criteria.duration_s=30".to_owned()])
        .unwrap();
    assert_eq!(
        longer.criteria,
        Criteria {
            duration_s: 30.0,
            ..mine()
        }
    );

    let folder = tempfile::tempdir().unwrap();
    let load = |text: &str| {
        let file = folder.path().join("some.toml");
        std::fs::write(&file, text).unwrap();
        Criteria::load(&file).map_err(|e| e.to_string())
    };
    assert_eq!(load(&format!("base = \"fast\"\n{MINE}")).unwrap(), mine());
    assert_eq!(load("base = \"fast\"\n").unwrap(), Criteria::default());
    let alone = MINE.replace("[criteria]\n", "").replace("criteria.", "");
    assert_eq!(load(&alone).unwrap(), mine());
    let five = Criteria {
        duration_s: 5.0,
        ..Criteria::default()
    };
    assert_eq!(load("duration_s = 5\n").unwrap(), five);
    for (text, words) in [
        ("duration_s = 5\ngait = 3\n", ["some.toml", "`gait`"]),
        ("duration_s = 0\n", ["some.toml", "`duration_s` is 0.0"]),
        (
            "[criteria]\nduration_s = -1\n",
            ["some.toml", "`criteria.duration_s`"],
        ),
        ("walks = true\n", ["some.toml", "`walks`"]),
    ] {
        let error = load(text).unwrap_err();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn nonsense_is_answered_by_its_key() {
    let gait =
        |line: &str| format!("[[criteria.gaits]]\nomega_v = 0\ngait = \"walking\"\n{line}\n");
    let change = |line: &str| format!("[[criteria.changes]]\nfrom = 0\nto = 3\n{line}\n");
    let no_changes = "[criteria]\nchanges = []\n";
    for (text, key, accepted) in [
        (
            "[criteria]\nomega_v = []\n".to_owned(),
            "criteria.omega_v",
            "1 to 1000",
        ),
        (
            "[criteria]\nomega_v = [0, 3, 0]\n".to_owned(),
            "criteria.omega_v",
            "different",
        ),
        (
            "[criteria]\nomega_v = [0, 3, 300]\n".to_owned(),
            "criteria.omega_v",
            "-100 to 100",
        ),
        (
            "[criteria]\nduration_s = 0\n".to_owned(),
            "criteria.duration_s",
            "above 0",
        ),
        (
            "[criteria]\nfastest_froude_min = -1\n".to_owned(),
            "criteria.fastest_froude_min",
            "asks nothing",
        ),
        (
            "[criteria]\nomega_v = [0, 1]\n".to_owned(),
            "criteria.gaits[1].omega_v",
            "one of the commands",
        ),
        (
            format!("{no_changes}{}{}", gait(""), gait("")),
            "criteria.gaits[1].omega_v",
            "no other gait",
        ),
        (
            no_changes.to_owned() + &gait("").replace("walking", "skipping"),
            "skipping",
            "walking",
        ),
        (
            no_changes.to_owned() + &gait("").replace("walking", "mixed"),
            "criteria.gaits[0].gait",
            "running",
        ),
        (
            no_changes.to_owned() + &gait("froude_min = 0.4\nfroude_max = 0.2"),
            "criteria.gaits[0].froude_min",
            "at most `froude_max`, 0.2",
        ),
        (
            no_changes.to_owned() + &gait("correlation = 1.5"),
            "criteria.gaits[0].correlation",
            "below 1",
        ),
        (
            no_changes.to_owned() + &gait("cost_of_transport_max = nan"),
            "criteria.gaits[0].cost_of_transport_max",
            "0",
        ),
        (
            no_changes.to_owned() + &gait("correlation = 0.5").replace("walking", "standing"),
            "criteria.gaits[0].gait",
            "to have bounds",
        ),
        (gait(""), "criteria.changes[0].to", "changes = []"),
        (
            change("phases = 0"),
            "criteria.changes[0].phases",
            "between 1 and 1000",
        ),
        (
            change("ramp_s = -1"),
            "criteria.changes[0].ramp_s",
            "between 0",
        ),
        (
            change("steady_s = 0"),
            "criteria.changes[0].steady_s",
            "above 0",
        ),
        (
            change("").replace("to = 3", "to = 0"),
            "criteria.changes[0].to",
            "another command",
        ),
        (
            change("").replace("to = 3", "to = 2"),
            "criteria.changes[0].to",
            "asks for a gait",
        ),
        (change("too = 3"), "`too`", "line"),
    ] {
        let error = Experiment::parse(&text, "mine.toml")
            .unwrap_err()
            .to_string();
        let words = ["mine.toml", key, accepted];
        assert!(
            words.iter().all(|word| error.contains(word)),
            "{text}: {error}"
        );
    }
    // What is rehearsed is the walk that is asked for.
    let none = "base = \"fast\"\n[criteria]\nchanges = []\n[[criteria.gaits]]\nomega_v = 3\ngait = \"running\"\n";
    let error = Experiment::parse(none, "mine.toml")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("rehearses") && error.contains("criteria.gaits"),
        "{error}"
    );
}

#[test]
fn a_run_is_judged_by_its_own_criteria_and_keeps_them() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let experiment = Experiment::parse(&format!("{TINY}{MINE}"), "mine.toml").unwrap();
    struct Asked(Until);
    impl gaitshift_experiment::Observer for Asked {
        fn progress(&mut self, progress: &gaitshift_experiment::Progress) {
            self.0.progress(progress);
        }
        fn evaluated(
            &mut self,
            _: &gaitshift_experiment::Progress,
            judgement: &gaitshift_experiment::Judgement,
            _: bool,
        ) {
            assert_eq!(judgement.rows.len(), 2);
            assert_eq!(judgement.checks.len(), mine().count());
        }
        fn note(&mut self, _: &str) {}
        fn stop_requested(&self) -> bool {
            self.0.stop_requested()
        }
    }
    let mut training = Training::new(experiment, &folder, "test").unwrap();
    let report = training.run(&mut Asked(Until::step(2500))).unwrap();
    assert_eq!(report.criteria, Some(mine().count()));
    // Two cannot train one run.
    drop(training);
    let evaluation = &Evaluation::read_all(&folder).unwrap()[0];
    assert_eq!(evaluation.checks.len(), mine().count());
    assert_eq!(evaluation.changes.len(), 1);
    assert_eq!(evaluation.motion(GaitClass::Running).unwrap().omega_v, 2.0);
    assert_eq!(Criteria::of_run(&folder).unwrap(), mine());

    let config = text(&folder, "config.toml");
    let path = folder.join("config.toml");
    std::fs::write(
        &path,
        config.replacen("froude_max = 0.3", "froude_max = 0.4", 1),
    )
    .unwrap();
    let error = Training::resume(&folder).unwrap_err().to_string();
    assert!(
        error.contains("`criteria.gaits[0].froude_max`") && error.contains("new run"),
        "{error}"
    );
    // A run of before there were any was judged by the paper's.
    std::fs::write(&path, "name = \"old\"\n[training.schedule]\nhorizon = []\n").unwrap();
    assert_eq!(Criteria::of_run(&folder).unwrap(), Criteria::default());
    assert_eq!(tiny().criteria, Criteria::default());
}
