//! Contract: what the phases say of the learner is what it learns with, step by step, which the course of the recipe `fast`
//! shows; phases of one's own bring their own course, and nothing of the base's is left in them; keys that went
//! elsewhere are answered by where they went.

use crate::common::{Until, tiny, unevaluated};
use gaitshift_experiment::{Experiment, Training};
use gaitshift_sac::Agent;

/// Step, learning rate, α, horizon, weight of the rehearsal, and `[ω_E, ω_f, ω_w, bound]` of the reward.
type Row = (u64, f64, f64, f64, f64, [f64; 4]);

/// `fast` at the start, middle and end of its phases.
const COURSE: [Row; 5] = [
    (0, 3e-4, 0.1, 200.0, 0.0, [0.06, 2.0, 0.0, 0.0]),
    (500_000, 3e-4, 0.1, 200.0, 0.0, [0.2, 2.0, 0.0, 0.0]),
    (6_500_000, 3e-4, 0.1, 50.0, 10.0, [0.2, 2.0, 0.0, 0.9]),
    (8_250_000, 3e-4, 0.1, 50.0, 10.0, [0.2, 2.0, 0.025, 0.9]),
    (10_000_000, 3e-4, 0.1, 50.0, 10.0, [0.2, 2.0, 0.05, 0.9]),
];

#[test]
fn fast_has_the_course_that_it_says() {
    let fast = Experiment::recipe("fast").unwrap();
    assert_eq!(fast.curriculum.total_steps(), 10_000_000);
    assert_eq!(fast.curriculum.rehearsal_start(), Some(6_500_000));
    for (step, rate, alpha, horizon, rehearsal, prices) in COURSE {
        let s = fast.learner_at(step);
        let r = fast.curriculum.at(step, &fast.task.reward).reward;
        let now = [s.learning_rate, s.alpha, s.horizon, s.rehearsal];
        let wanted = [rate, alpha, horizon, rehearsal];
        let near = now.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near, "{step}: {s:?}");
        let now = [r.omega_e, r.omega_f, r.omega_w, r.energy_cap];
        let near = now.iter().zip(prices).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near, "{step}: {r:?}");
    }
}

#[test]
fn robust_begins_as_fast_does() {
    let [fast, robust] = ["fast", "robust"].map(|name| Experiment::recipe(name).unwrap());
    let (as_fast, more) = robust.curriculum.phases.split_at(3);
    assert_eq!(as_fast, fast.curriculum.phases);
    assert!(more.len() == 1 && more[0].randomization.is_some());
    let randomized = |step| robust.curriculum.randomizes_by(step);
    assert!(!randomized(9_999_999) && randomized(10_000_000) && randomized(20_000_000));
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
    assert_eq!(own.learning_rate, 3e-4);
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
    let own = [0.1, 3e-4, 0.99];
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
            "[training]\nentropy_command_divisor = 2.0\n",
            "entropy_command_divisor",
            "alpha = 0.05",
        ),
        (
            &format!("{phase}learner = {{ entropy_share_at_zero = 0.25 }}\n"),
            "entropy_share_at_zero",
            "no longer exists",
        ),
        (
            &format!("{phase}redraw_interval_s = 2.5\n"),
            "redraw_interval_s",
            "curriculum.command",
        ),
        (
            "[learner]\nactor_average_decay = 0.9998\n",
            "actor_average_decay",
            "no longer exists",
        ),
        (
            "[learner]\nactor_layer_norm = true\n",
            "actor_layer_norm",
            "no longer exists",
        ),
        (
            "[learner]\nmax_grad_norm = 1.0\n",
            "max_grad_norm",
            "no longer exists",
        ),
        (
            "[training]\naverage_evaluations = 3\n",
            "average_evaluations",
            "no longer exists",
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
            "[task.reward]\nspeed_limit_m_per_s = 2.5\n",
            "speed_limit_m_per_s",
            "[[task.reward.extra]]",
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
        (
            "[training]\nsymmetry = \"network\"\n",
            "network",
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
