//! Contract: what the phases say of the learner is what it learns with, step by step; the recipe `fast` has the course that
//! it always had; phases of one's own bring their own course, and nothing of the base's is left in them; keys that went
//! elsewhere are answered by where they went.

mod common;
use common::{Until, tiny, unevaluated};
use gaitshift_experiment::{Experiment, Training};
use gaitshift_sac::Agent;

/// Step, learning rate, horizon, weight of the rehearsal, share of the entropy at 0, and `[ω_E, ω_f, divisor and floor of
/// ω_E, ω_w, bound]` of the reward.
type Row = (u64, f64, f64, f64, f64, [f64; 6]);

/// What `fast` had when learning rate and horizon were points over shares of the run, and the rehearsal a step of it:
/// learning_rate = [[0.171, 5e-4], [0.314, 5e-5], [0.3144, 5e-4], [0.771, 5e-4], [0.886, 1e-4], [1.0, 2e-5]],
/// horizon = [[0.3142, 200.0], [0.3144, 50.0], [0.6, 50.0], [0.714, 75.0]], after_steps = 2_750_000.
const BEFORE: [Row; 19] = [
    (
        0,
        5.00000e-04,
        200.000,
        0.0,
        1.00000,
        [0.060000, 0.500000, 6.000000, 0.030000, 0.000000, 0.0],
    ),
    (
        1_000_000,
        5.00000e-04,
        200.000,
        0.0,
        1.00000,
        [0.220000, 1.500000, 6.000000, 0.030000, 0.000000, 0.0],
    ),
    (
        1_496_000,
        5.00000e-04,
        200.000,
        0.0,
        1.00000,
        [0.332800, 2.000000, 6.000000, 0.030000, 0.000000, 0.0],
    ),
    (
        1_600_000,
        4.62687e-04,
        200.000,
        0.0,
        1.00000,
        [0.346667, 2.000000, 6.000000, 0.030000, 0.000000, 0.0],
    ),
    (
        2_000_000,
        3.18831e-04,
        200.000,
        0.0,
        1.00000,
        [0.400000, 2.000000, 6.000000, 0.030000, 0.000000, 0.0],
    ),
    (
        2_500_000,
        1.39011e-04,
        200.000,
        0.0,
        1.00000,
        [0.466667, 2.000000, 6.000000, 0.030000, 0.000000, 0.0],
    ),
    (
        2_740_000,
        5.26973e-05,
        200.000,
        0.0,
        1.00000,
        [0.498667, 2.000000, 6.000000, 0.030000, 0.000000, 0.0],
    ),
    (
        2_760_000,
        5.00000e-04,
        50.000,
        10.0,
        1.00000,
        [0.250000, 0.500000, 6.000000, 0.030000, 0.000000, 0.9],
    ),
    (
        4_000_000,
        5.00000e-04,
        50.000,
        10.0,
        1.00000,
        [0.250000, 0.500000, 6.000000, 0.030000, 0.000000, 0.9],
    ),
    (
        5_249_999,
        5.00000e-04,
        50.000,
        10.0,
        1.00000,
        [0.250000, 0.500000, 6.000000, 0.030000, 0.000000, 0.9],
    ),
    (
        5_500_000,
        5.00000e-04,
        56.266,
        10.0,
        0.87500,
        [0.258333, 0.916667, 5.500000, 0.041667, 0.000000, 0.9],
    ),
    (
        6_000_000,
        5.00000e-04,
        68.797,
        10.0,
        0.62500,
        [0.275000, 1.750000, 4.500000, 0.065000, 0.000000, 0.9],
    ),
    (
        6_500_000,
        5.00000e-04,
        75.000,
        10.0,
        0.37500,
        [0.291667, 2.583333, 3.500000, 0.088333, 0.000000, 0.9],
    ),
    (
        6_740_000,
        5.00000e-04,
        75.000,
        10.0,
        0.25500,
        [0.299667, 2.983333, 3.020000, 0.099533, 0.000000, 0.9],
    ),
    (
        7_000_000,
        3.99130e-04,
        75.000,
        10.0,
        0.25000,
        [0.300000, 3.000000, 3.000000, 0.100000, 0.031250, 0.9],
    ),
    (
        7_500_000,
        2.00373e-04,
        75.000,
        10.0,
        0.25000,
        [0.300000, 3.000000, 3.000000, 0.100000, 0.093750, 0.9],
    ),
    (
        8_000_000,
        8.01504e-05,
        75.000,
        10.0,
        0.25000,
        [0.300000, 3.000000, 3.000000, 0.100000, 0.156250, 0.9],
    ),
    (
        8_500_000,
        4.00501e-05,
        75.000,
        10.0,
        0.25000,
        [0.300000, 3.000000, 3.000000, 0.100000, 0.218750, 0.9],
    ),
    (
        8_749_999,
        2.00001e-05,
        75.000,
        10.0,
        0.25000,
        [0.300000, 3.000000, 3.000000, 0.100000, 0.250000, 0.9],
    ),
];

#[test]
fn fast_has_the_course_that_it_had() {
    let fast = Experiment::recipe("fast").unwrap();
    assert_eq!(fast.curriculum.total_steps(), 8_750_000);
    assert_eq!(fast.curriculum.rehearsal_start(), Some(2_750_000));
    for (step, rate, horizon, rehearsal, share, prices) in BEFORE {
        let s = fast.learner_at(step);
        let r = fast.curriculum.at(step, &fast.task.reward).reward;
        // The shares of the run had three digits: their bends were up to 5000 steps from where the phases have them.
        assert!((s.learning_rate - rate).abs() < 2e-6, "{step}: {s:?}");
        assert!((s.horizon - horizon).abs() < 0.05, "{step}: {s:?}");
        assert_eq!((s.rehearsal, s.alpha), (rehearsal, 0.1), "{step}");
        assert_eq!(s.entropy_command_divisor, 2.0);
        assert!(
            (s.entropy_share_at_zero - share).abs() < 1e-9,
            "{step}: {s:?}"
        );
        let now = [
            r.omega_e,
            r.omega_f,
            r.energy_command_divisor,
            r.omega_e_floor,
            r.omega_w,
            r.energy_cap,
        ];
        for (now, before) in now.iter().zip(prices) {
            assert!((now - before).abs() < 5e-6, "{step}: {r:?}");
        }
    }
}

#[test]
fn a_recipe_without_courses_keeps_what_the_learner_has() {
    for name in ["paper", "journal"] {
        let recipe = Experiment::recipe(name).unwrap();
        for step in [0, 600_000, 9_999_999] {
            assert_eq!(recipe.learner_at(step), recipe.own_learner_settings());
        }
    }
}

// Phases of one's own kept the learning rate and the horizon of the recipe they replaced, whose shares of the run cut them in
// the middle: README's example learned with 5e-5 from 31 % of its run on.
#[test]
fn phases_of_ones_own_bring_their_own_course() {
    let phases = "[[curriculum.phases]]\nname = \"walk\"\nsteps = 2_000_000\nomega_v = [-0.2, 0.2]\n\
        [[curriculum.phases]]\nname = \"widen\"\nsteps = 3_000_000\nomega_v = [-0.2, 0.2]\nomega_v_end = [-0.5, 3.5]\n";
    let mine = Experiment::parse(&format!("base = \"fast\"\n{phases}"), "mine.toml").unwrap();
    let own = mine.own_learner_settings();
    for step in (0..5_000_000).step_by(10_000) {
        assert_eq!(mine.learner_at(step), own, "{step}");
    }
    assert_eq!(own.learning_rate, 5e-4);
    assert_eq!(mine.curriculum.rehearsal_start(), None);
}

/// α, learning rate, γ and weight of the rehearsal that a stopped run's learner has.
fn learner(experiment: Experiment, stop_at: u64) -> (u64, [f64; 4]) {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let report = Training::new(experiment, &folder, "test")
        .unwrap()
        .run(&mut Until::step(stop_at))
        .unwrap();
    let agent = Agent::load(&folder.join("checkpoint/agent.safetensors")).unwrap();
    let c = agent.config();
    let has = [
        agent.alpha(),
        c.learning_rate,
        c.gamma,
        agent.rehearsal_weight(),
    ];
    (report.step, has)
}

#[test]
fn the_learner_has_the_settings_of_its_last_step() {
    let experiment = tiny();
    let mut experiment_without = unevaluated();
    experiment_without.curriculum.phases = experiment.curriculum.phases.clone();
    let (step, has) = learner(experiment_without.clone(), 4000);
    // The settings of a step hold for its updates; the last step began as many steps earlier as there are environments.
    let s = experiment.learner_at(step - experiment.training.environments as u64);
    assert!(
        s.horizon > 60.0 && s.horizon < 100.0,
        "in the middle: {s:?}"
    );
    assert_eq!(has, [s.alpha, s.learning_rate, 1.0 - 1.0 / s.horizon, 0.0]);
    let (step, has) = learner(experiment_without, 10_000);
    assert_eq!(step, 6000);
    let s = experiment.learner_at(5996);
    assert!(s.rehearsal > 2.0 && s.rehearsal < 2.1, "{s:?}");
    // What no phase names is the learner's own, to the bit.
    let own = [0.1, 5e-4, 0.995];
    assert_eq!(has, [own[0], own[1], own[2], s.rehearsal]);
}

#[test]
fn values_that_cannot_be_are_named() {
    let error = |text: &str| {
        let error = Experiment::parse(text, "mine.toml").unwrap_err();
        error.to_string()
    };
    let phase = "[[curriculum.phases]]\nname = \"a\"\nsteps = 1000\nomega_v = [0, 1]\n";
    for (line, words) in [
        (
            "learner = { learning_rate = 0.0 }",
            ["phases[0].learner.learning_rate", "greater than 0"],
        ),
        (
            "learner_end = { alpha = -0.1 }",
            ["phases[0].learner_end.alpha", "0 or greater"],
        ),
        (
            "learner = { horizon = 0.5 }",
            ["phases[0].learner.horizon", "1 control period"],
        ),
        (
            "learner = { rehearsal = nan }",
            ["phases[0].learner.rehearsal", "0 or greater"],
        ),
        (
            "learner = { learningrate = 1.0 }",
            ["mine.toml", "did you mean `learning_rate`"],
        ),
    ] {
        let error = error(&format!("{phase}{line}\n"));
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
    let auto = format!(
        "{phase}learner = {{ alpha = 0.1 }}\n[learner]\ntemperature = {{ kind = \"auto\", initial = 0.2 }}\n"
    );
    let error = error(&auto);
    assert!(
        error.contains("phases[0]") && error.contains("learner.temperature"),
        "{error}"
    );
}

// Keys that moved or went were answered by a list of others, or by one that only looks alike.
#[test]
fn a_key_that_went_elsewhere_is_answered_by_where() {
    let phase = "[[curriculum.phases]]\nname = \"a\"\nsteps = 1000\nomega_v = [0, 1]\n";
    for (text, key, remedy) in [
        (
            "[training.schedule]\nhorizon = [[0.5, 50.0]]\n",
            "schedule",
            "learner_end",
        ),
        (
            "[training.rehearsal]\nafter_steps = 5\n",
            "after_steps",
            "rehearsal = 10",
        ),
        (
            "[training.rehearsal]\nweight = 5.0\n",
            "weight",
            "rehearsal = 10",
        ),
        (
            "[task.reward]\nentropy_command_divisor = 2.0\n",
            "entropy_command_divisor",
            "[training]",
        ),
        (
            &format!("{phase}reward_end = {{ entropy_share_at_zero = 0.25 }}\n"),
            "entropy_share_at_zero",
            "learner_end",
        ),
        (
            "[task.reward]\nhorizon_command_divisor = 1.0\n",
            "horizon_command_divisor",
            "no longer exists",
        ),
        (
            "[task.reward]\nhorizon_share_floor = 1.0\n",
            "horizon_share_floor",
            "no longer exists",
        ),
        (
            "[task.reward]\nalive_command_factor = 1.0\n",
            "alive_command_factor",
            "no longer exists",
        ),
        (
            "[task.reward]\nenergy_reference_period_s = 0.01\n",
            "energy_reference_period_s",
            "no longer exists",
        ),
        (
            "[learner]\nnoise_correlation = 0.5\n",
            "noise_correlation",
            "no longer exists",
        ),
        (
            "[learner]\nactor_every = 2\n",
            "actor_every",
            "no longer exists",
        ),
        (
            "[learner]\nmirror_loss_weight = 1.0\n",
            "mirror_loss_weight",
            "no longer exists",
        ),
        (
            "[learner]\nmirrored_fraction = 0.5\n",
            "mirrored_fraction",
            "training.symmetry",
        ),
        (
            "[learner]\nrehearsal_weight = 1.0\n",
            "rehearsal_weight",
            "rehearsal = 10",
        ),
        (
            "[learner]\nrehearsal_rows = 64\n",
            "rehearsal_rows",
            "training.rehearsal.rows",
        ),
        (
            "[training]\nsymmetry = \"loss\"\n",
            "loss",
            "no longer exists",
        ),
    ] {
        let error = Experiment::parse(text, "mine.toml")
            .unwrap_err()
            .to_string();
        let words = ["mine.toml", &format!("`{key}`"), remedy, "line "];
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
        assert!(
            !error.contains("did you mean") && !error.contains("expected one of"),
            "{error}"
        );
    }
    // On a command line too.
    let fast = Experiment::recipe("fast").unwrap();
    let error = fast
        .with_values(&["training.schedule.alpha=[]".to_owned()])
        .unwrap_err();
    assert!(error.to_string().contains("learner_end"), "{error}");
}
