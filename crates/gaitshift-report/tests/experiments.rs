//! Contract: the study's experiments are those of the papers: names that claims ask for, schedules as long, seeds as many; with the
//! learner of `fast` they learn otherwise, and what is learned stays.

use gaitshift_experiment::Symmetry;
use gaitshift_report::{StudyLearner, study_experiments};

#[test]
fn experiments_are_as_long_as_the_papers_and_as_many_as_said() {
    let sweeps = study_experiments(StudyLearner::Papers).unwrap();
    let seeds = |sweep: usize| {
        let variants = sweeps[sweep].variants.len();
        sweeps[sweep].trials.len() / variants
    };
    assert_eq!((sweeps.len(), seeds(0), seeds(1)), (2, 5, 3));
    let names: Vec<&str> = sweeps
        .iter()
        .flat_map(|s| s.variants.iter().map(|v| v.name.as_str()))
        .collect();
    for name in [
        "paper",
        "paper, without phase I",
        "paper, without the energy term",
        "journal",
        "journal, without 1/(1+ω_v)",
        "journal, full range from the start",
        "journal, high range from the start",
        "journal, without its first phase",
        "fast",
    ] {
        assert!(names.contains(&name), "{name}");
    }
    for trial in sweeps.iter().flat_map(|s| &s.trials) {
        let steps = trial.experiment.curriculum.total_steps();
        if trial.experiment.name != "fast" {
            assert_eq!(steps, 10_000_000, "{}", trial.experiment.name);
        }
    }
}

#[test]
fn what_is_left_out_is_left_out() {
    let sweeps = study_experiments(StudyLearner::Papers).unwrap();
    let experiment = |name: &str| {
        let mut trials = sweeps.iter().flat_map(|s| &s.trials);
        let trial = trials.find(|t| t.experiment.name == name);
        trial
            .unwrap_or_else(|| panic!("no {name}"))
            .experiment
            .clone()
    };
    let first_range = |name: &str| experiment(name).curriculum.phases[0].omega_v;
    assert_eq!(first_range("paper"), [-0.2, 0.2]);
    assert_eq!(first_range("paper, without phase I"), [-0.5, 3.5]);
    assert_eq!(
        first_range("journal, high range from the start"),
        [1.5, 2.5]
    );
    assert_eq!(experiment("journal").task.reward.command_divisor, 1.0);
    assert_eq!(
        experiment("journal, without 1/(1+ω_v)")
            .task
            .reward
            .command_divisor,
        0.0
    );
    // The full weights from the start, on the range of the two phases that it replaces.
    let without = experiment("journal, without its first phase");
    assert_eq!(without.curriculum.phases[0].omega_v, [0.0, 1.0]);
    let first = without.curriculum.at(0, &without.task.reward);
    assert_eq!((first.reward.omega_e, first.reward.omega_s), (0.2, 0.15));
    // In no phase of it does energy cost anything.
    let without = experiment("paper, without the energy term");
    assert_eq!(without.task.reward.omega_e, 0.0);
    for step in [0, 400_000, 3_000_000, 9_000_000] {
        assert_eq!(
            without
                .curriculum
                .at(step, &without.task.reward)
                .reward
                .omega_e,
            0.0
        );
    }
}

#[test]
fn with_the_learner_of_fast_only_the_learning_differs() {
    let all = |learner| study_experiments(learner).unwrap();
    for (papers, fast) in all(StudyLearner::Papers)
        .iter()
        .zip(&all(StudyLearner::Fast))
    {
        assert_eq!(papers.variants, fast.variants);
        for (papers, fast) in papers.trials.iter().zip(&fast.trials) {
            let (papers, fast) = (&papers.experiment, &fast.experiment);
            let learner = &fast.learner;
            assert_eq!((learner.critic_layer_norm, learner.n_step), (true, 3));
            let training = &fast.training;
            assert_eq!((training.environments, training.steps_per_update), (32, 16));
            assert_eq!(
                (&papers.task, &papers.body, &papers.curriculum),
                (&fast.task, &fast.body, &fast.curriculum)
            );
            assert_eq!(
                (papers.learner.gamma, &papers.learner.temperature),
                (learner.gamma, &learner.temperature)
            );
            assert_eq!(training.symmetry, Symmetry::Replay);
        }
    }
}
