//! Contract: before it is trained, an experiment is told how it differs from its base and what of it looks like a mistake;
//! a recipe as it comes differs from nothing.

use gaitshift_experiment::{Experiment, RECIPES, Review};

fn review(text: &str) -> Review {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, text).unwrap();
    let experiment = Experiment::read(&path).unwrap();
    Review::of(&path.display().to_string(), &experiment).unwrap()
}

fn warned(text: &str, words: &[&str]) {
    let warnings = review(text).warnings;
    let all_in_one = |w: &String| words.iter().all(|word| w.contains(word));
    assert!(
        warnings.iter().any(all_in_one),
        "no {words:?} in {warnings:#?}"
    );
}

const PHASE: &str =
    "[[curriculum.phases]]\nname = \"only\"\nsteps = 1000000\nomega_v = [-0.2, 3.5]\n";

#[test]
fn recipes_are_nothing_to_warn_of_and_name_their_base() {
    for (name, _) in RECIPES.into_iter().filter(|(name, _)| *name != "robust") {
        let mut experiment = Experiment::recipe(name).unwrap();
        // Depends on the machine.
        experiment.learner.threads = 1;
        let review = Review::of(name, &experiment).unwrap();
        assert_eq!(review.base.as_deref(), (name == "fast").then_some("paper"));
        assert_eq!(review.warnings, Vec::<String>::new(), "{name}");
    }
}

// It was compared with `paper`, and its phases had "3 of 10000000 steps instead of 3 of 10000000".
#[test]
fn a_recipe_with_changed_values_differs_from_itself_in_these() {
    let fast = Experiment::recipe("fast").unwrap();
    let changed = ["body.leg_length_m=0.88".to_owned()];
    let review = Review::of("fast", &fast.with_values(&changed).unwrap()).unwrap();
    assert_eq!(review.base.as_deref(), Some("fast"));
    assert_eq!(review.differences.len(), 1, "{:?}", review.differences);
    let told = |w: &String| w.contains("`task.termination.min_hip_height_m`");
    assert!(review.warnings.iter().any(told), "{:?}", review.warnings);
    let review = Review::of("fast", &fast).unwrap();
    let phases = |d: &&String| d.starts_with("`curriculum.phases`,");
    let phases = review.differences.iter().find(phases).unwrap();
    assert!(phases.contains("`I, stepping`"), "{phases}");
}

// A longer leg with the height of a fall of the shorter one was nothing to warn of.
#[test]
fn a_leg_of_another_length_is_told_the_height_of_a_fall() {
    let leg = "base = \"fast\"\n[body]\nleg_length_m = 0.88\n";
    warned(
        leg,
        &[
            "`task.termination.min_hip_height_m` is 0.68",
            "77 %",
            "0.748",
        ],
    );
    let both = format!("{leg}[task.termination]\nmin_hip_height_m = 0.748\n");
    let warnings = review(&both).warnings;
    assert!(
        !warnings.iter().any(|w| w.contains("min_hip_height_m")),
        "{warnings:?}"
    );
}

// It was taken in silence, and every phase went on with the horizon of its own.
#[test]
fn a_setting_that_every_phase_replaces_is_told_to_have_no_effect() {
    let gamma = "base = \"fast\"\n[learner]\ngamma = 0.995\n";
    warned(
        gamma,
        &["`learner.gamma` is 0.995", "no effect", "`horizon`"],
    );
    // A phase without a horizon has that of γ.
    let used = format!("{gamma}{PHASE}");
    let warnings = review(&used).warnings;
    assert!(
        !warnings.iter().any(|w| w.contains("no effect")),
        "{warnings:?}"
    );
}

// Listed as a difference, and nothing said that the base's phases went on with rewards of their own.
#[test]
fn a_reward_that_every_phase_replaces_is_told_to_have_no_effect() {
    let phase = |more: &str| format!("{PHASE}{more}\n");
    let reward = "[task.reward]\nomega_e = 0.3\n";
    let told = ["`task.reward.omega_e` is 0.3", "no effect"];
    let text = format!("{reward}{}", phase("reward = { omega_e = 0.06 }"));
    warned(&text, &told);
    let none = |text: &str| {
        let warnings = review(text).warnings;
        assert!(
            !warnings.iter().any(|w| w.contains("no effect")),
            "{warnings:?}"
        );
    };
    none(&format!("{text}{}", phase("").replace("only", "other")));
    none(&format!(
        "{reward}{}",
        phase("reward_end = { omega_e = 0.06 }")
    ));
    let term = "[[task.reward.extra]]\nname = \"q\"\nweight = 3.0\nexpression = \"-theta_rad^2\"\n";
    let silent = phase("reward_extra = { q = 0.0 }");
    warned(
        &format!("{term}{silent}"),
        &["`q`", "`task.reward.extra`", "no effect"],
    );
    none(&format!("{term}{silent}reward_extra_end = {{ q = 1.0 }}\n"));
    none(&format!("{term}{}", phase("reward_extra = { q = 1.0 }")));
    let rehearsal = "[training.rehearsal]\nomega_v = [0.0, 0.1]\n";
    warned(
        &format!("{rehearsal}{PHASE}"),
        &["`training.rehearsal`", "no effect"],
    );
}

// It showed none.
#[test]
fn a_recipe_on_another_differs_from_that() {
    let robust = Experiment::recipe("robust").unwrap();
    let review = Review::of("robust", &robust).unwrap();
    assert_eq!(review.base.as_deref(), Some("fast"));
    // Three dozen values are one sentence.
    assert_eq!(
        review.differences,
        [
            "`task.reward.extra[0].expression` from nothing to \"min(x_velocity_m_per_s, 0.3)\"",
            "`task.reward.extra[0].name` from nothing to \"going_on\"",
            "`task.reward.extra[0].weight` from nothing to 0.0",
            "`curriculum.phases`, 4 of 16000000 steps in all instead of 3 of 10000000 steps in all",
        ]
    );
    let set = ["curriculum.phases.III.randomization.share=0.5".to_owned()];
    let text = "base = \"robust\"\n[curriculum.phases.III.randomization]\nshare = 0.5\nactuator_factor = [0.8, 1]\n";
    assert_eq!(
        self::review(text).differences,
        [
            "`curriculum.phases.III.randomization.actuator_factor` from [1.0, 1.0] to [0.8, 1.0]",
            "`curriculum.phases.III.randomization.share` from 0.7 to 0.5",
        ]
    );
    let changed = robust.with_values(&set).unwrap();
    assert_eq!(
        Review::of("robust", &changed).unwrap().differences,
        ["`curriculum.phases.III.randomization.share` from 0.7 to 0.5"]
    );
}

// A rule that always holds passed without a word and ended every episode.
#[test]
fn rules_that_end_episodes_at_once_are_warned_of() {
    let rule = |expression: &str| {
        format!(
            "base = \"fast\"\n[[task.termination.extra]]\nname = \"own\"\nexpression = \"{expression}\"\n"
        )
    };
    for expression in ["1", "theta_rad", "omega_v < 9", "period_positive_work_j"] {
        warned(
            &rule(expression),
            &["`own`", "first control period", expression],
        );
    }
    for expression in ["z_m > 1.3", "abs(theta_rad) > 0.5", "0", "time_s > 5"] {
        let own = |w: &&String| w.contains("`own`");
        let warnings = review(&rule(expression)).warnings;
        assert_eq!(warnings.iter().find(own), None, "{expression}");
    }
}

// A number of 309 digits.
#[test]
fn large_numbers_are_short() {
    let review = review("base = \"fast\"\n[curriculum.command]\nredraw_ramp_s = 1e308\n");
    assert_eq!(
        review.differences,
        ["`curriculum.command.redraw_ramp_s` from 0.4 to 1e308"]
    );
}

#[test]
fn differences_are_those_from_the_base() {
    let review = review("base = \"fast\"\n[body]\nfriction = 0.6\n");
    assert_eq!(review.base.as_deref(), Some("fast"));
    assert_eq!(review.differences, ["`body.friction` from 1.0 to 0.6"]);
    let review = self::review(&format!("base = \"fast\"\n{PHASE}"));
    assert_eq!(review.differences.len(), 1, "{:?}", review.differences);
    assert!(review.differences[0].contains("1 of 1000000 steps"));
    // Phases that have kept their names are told apart by them.
    let text = "base = \"fast\"\n[curriculum.phases.\"I, stepping\"]\nsteps = 7\n";
    assert_eq!(
        self::review(text).differences,
        ["`curriculum.phases.I, stepping.steps` from 500000 to 7"]
    );
    let changed = Experiment::recipe("paper").unwrap();
    let changed = changed.with_values(&["seed=3".to_owned()]).unwrap();
    let review = Review::of("paper", &changed).unwrap();
    assert_eq!(review.differences, ["`seed` from 1 to 3"]);
}

#[test]
fn phases_of_ones_own_inherit_nothing_to_warn_of() {
    let text = format!("base = \"fast\"\n[learner]\nthreads = 1\n{PHASE}");
    assert_eq!(review(&text).warnings, Vec::<String>::new());
    // What no evaluation has judged is no walk to rehearse.
    let text = format!("{text}learner = {{ rehearsal = 10.0 }}\n");
    warned(&text, &["rehearses before the first evaluation"]);
}

#[test]
fn what_is_never_reached_is_warned_of() {
    let phase = |steps: u64, range: &str| {
        format!("[[curriculum.phases]]\nname = \"only\"\nsteps = {steps}\nomega_v = {range}\n")
    };
    warned(
        &phase(5000, "[0, 3]"),
        &["training.learning_starts", "nothing is learned"],
    );
    warned(
        &phase(100_000, "[0, 3]"),
        &["evaluation_interval_steps", "no controller"],
    );
    // It has a header.
    warned(
        &phase(15_000, "[0, 3]"),
        &["metrics_interval_steps", "`metrics.csv` gets no row"],
    );
    warned(&phase(1_000_000, "[0, 2]"), &["command 3", "running"]);
    warned(&phase(1_000_000, "[1, 3]"), &["command 0", "walking"]);
    warned(
        &phase(1_000_000, "[0, 3]"),
        &["reaches 3.5 of `criteria.omega_v`", "from 0 to 3"],
    );
    warned(
        "[body]\nleg_length_m = 1.0\n",
        &["leg_length_m", "thigh_distance_m"],
    );
}

// Episodes were over before, and nothing said so.
#[test]
fn what_an_episode_does_not_last_for_is_warned_of() {
    warned(
        &format!("[curriculum.command]\nhold_periods = 0\nredraw_interval_s = 200.0\n{PHASE}"),
        &[
            "`curriculum.command.redraw_interval_s` is 200",
            "episodes last",
        ],
    );
    let phase = |table: &str| format!("{PHASE}randomization = {{ {table} }}\n");
    for (far, near, name) in [
        (
            "pushes = { forward_n = [-50.0, 50.0], interval_s = 1000.0 }",
            "pushes = { forward_n = [-50.0, 50.0], interval_s = 10.0 }",
            "pushes.interval_s",
        ),
        (
            "terrain = { slope_rad = [0.0, 0.1], slope_from_m = [500.0, 600.0] }",
            "terrain = { slope_rad = [0.0, 0.1], slope_from_m = [1.0, 600.0] }",
            "terrain.slope_rad",
        ),
        (
            "terrain = { steps = { height_m = [0.0, 0.02], from_m = 500.0 } }",
            "terrain = { steps = { height_m = [0.0, 0.02], from_m = 2.0 } }",
            "terrain.steps",
        ),
        (
            "terrain = { uneven = { height_m = [0.0, 0.02], from_m = 500.0 } }",
            "terrain = { uneven = { height_m = [0.0, 0.0], from_m = 500.0 } }",
            "terrain.uneven",
        ),
    ] {
        warned(
            &phase(far),
            &[
                "`curriculum.phases.only.randomization",
                name,
                "episodes last",
            ],
        );
        let warnings = review(&phase(near)).warnings;
        assert!(
            !warnings.iter().any(|w| w.contains("episodes last")),
            "{warnings:?}"
        );
    }
}

// It trained like a phase without any, in silence.
#[test]
fn a_randomization_that_changes_nothing_is_warned_of() {
    let phase = |table: &str| format!("{PHASE}randomization = {{ {table} }}\n");
    let told = [
        "`curriculum.phases.only.randomization`",
        "changes nothing",
        "`share`",
    ];
    for table in [
        "share = 0.7",
        "share = 0.0, latency_s = [0.0, 0.02]",
        "body = { friction = [1.0, 1.0] }",
        "pushes = { interval_s = 2.0 }",
    ] {
        warned(&phase(table), &told);
    }
    for table in [
        "latency_s = [0.0, 0.02]",
        "body = { friction = [0.9, 1.0] }",
        "hip_com_height_m = [0.0, 0.1]",
        "actuator_factor = [0.8, 1.0]",
        "noise = { h_m = 0.01 }",
        "pushes = { forward_n = [-50.0, 50.0] }",
    ] {
        let warnings = review(&phase(table)).warnings;
        let one = |w: &String| w.contains("changes nothing");
        assert!(!warnings.iter().any(one), "{table}: {warnings:?}");
    }
}

// Nothing was said of a hip's height in cm, an angle in degrees, and what else only its size tells.
#[test]
fn units_that_were_mistaken_are_warned_of() {
    let base = "base = \"fast\"\n";
    let termination = |line: &str| format!("{base}[task.termination]\n{line}\n");
    warned(
        &termination("min_hip_height_m = 68"),
        &["`task.termination.min_hip_height_m` is 68", "64 of 64"],
    );
    warned(
        &termination("pitch_limit_rad = 80"),
        &["`task.termination.pitch_limit_rad` is 80", "1.396 rad"],
    );
    warned(
        &termination("pitch_limit_rad = 0.01"),
        &["`task.termination.pitch_limit_rad` is 0.01", "of 64"],
    );
    warned(
        &format!("{base}[learner]\nlearning_rate = 3\n"),
        &["learning rate of 3"],
    );
    warned(
        &format!("{base}[body]\nstroke_m = 10\n"),
        &["`body.stroke_m` is 10"],
    );
    warned(
        &format!("{base}{}", PHASE.replace("3.5", "50")),
        &["commands go up to 50"],
    );
    warned(
        &format!("{base}[curriculum.command]\nredraw_interval_s = 0.001\n"),
        &["`curriculum.command.redraw_interval_s` is 0.001"],
    );
}

#[test]
fn a_reward_with_which_falling_pays_is_warned_of() {
    let extra = |weight: f64| {
        format!(
            "base = \"fast\"\n[[task.reward.extra]]\nname = \"mine\"\nweight = {weight:?}\nexpression = \"-1\"\n"
        )
    };
    warned(&extra(1000.0), &["falling pays", "`c2`"]);
    warned(&extra(1e300), &["earns -1.0e300 on average"]);
    let small = review(&extra(0.1)).warnings;
    assert!(
        !small.iter().any(|w| w.contains("falling pays")),
        "{small:?}"
    );
}
