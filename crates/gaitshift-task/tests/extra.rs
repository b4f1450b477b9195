//! Contract: a reward term of one's own adds its weighted expression to the reward, a rule of one's own ends the episode as
//! a fall under its name; a value that is not finite is an error where the run begins and fails the step later; phases
//! may replace and move the weights; mirrored states are worth the same where the expression is symmetric; without any,
//! nothing changes.

use gaitshift_body::{Body, BodyParameters};
use gaitshift_task::{
    Curriculum, EndReason, Environment, EnvironmentBatch, MOST_EXTRA, Opening, Phase, StepOutcome,
    TaskParameters, VectorEnvironment, info_names,
};

fn task(text: &str) -> TaskParameters {
    toml::from_str(text).unwrap_or_else(|e| panic!("{e}"))
}

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

/// Steps under the commands of a list, from the default start under the command 1.
fn steps(task: &TaskParameters, commands: &[[f64; 2]]) -> (Environment, Vec<StepOutcome>) {
    let body = body();
    let start = Environment::default_start(&body, task);
    let mut environment = Environment::new(&body, start, 1.0);
    let outcomes = commands
        .iter()
        .map(|&command| environment.step(&body, task, &task.reward, command))
        .collect();
    (environment, outcomes)
}

fn term(expression: &str) -> String {
    format!("[[reward.extra]]\nname = \"own\"\nweight = 2.0\nexpression = \"{expression}\"\n")
}

fn rule(name: &str, expression: &str) -> String {
    format!("[[termination.extra]]\nname = \"{name}\"\nexpression = \"{expression}\"\n")
}

#[test]
fn a_term_is_its_weight_times_its_expression() {
    let plain = steps(&TaskParameters::default(), &[[0.5, -0.25]; 3]).1;
    let value = |expression: &str| {
        let task = task(&term(expression));
        let (environment, outcomes) = steps(&task, &[[0.5, -0.25]; 3]);
        let last = outcomes[2];
        let own = last.terms.extra[0];
        assert_eq!(last.terms.extra[1..], [0.0; MOST_EXTRA - 1]);
        assert_eq!(last.terms.sum(), plain[2].terms.sum() + own, "{expression}");
        (own, environment)
    };
    let (own, environment) = value("theta_rad");
    assert_eq!(own, 2.0 * environment.state.theta);
    // Powers bind more tightly than the sign, as on paper.
    let (own, environment) = value("-x_velocity_m_per_s^2");
    let speed: f64 = environment.state.x_dot;
    assert!((own + 2.0 * speed * speed).abs() < 1e-12 && own < 0.0);
    assert_eq!(
        value("right_command + 10 * left_command + omega_v").0,
        2.0 * (0.5 - 2.5 + 1.0)
    );
    assert_eq!(value("time_s").0, 2.0 * 0.03);
    assert_eq!(value("time_s > 0.02 && omega_v == 1 ? 3 : 1 / 0").0, 6.0);
    let (own, environment) = value("actuator_positive_work_j");
    assert_eq!(own, 2.0 * environment.account.positive_work());
    for (leg, name) in ["right", "left"].into_iter().enumerate() {
        let (own, environment) = value(&format!("{name}_sole_height_m"));
        assert_eq!(own, 2.0 * body().sole_height(&environment.state, leg));
    }
}

#[test]
fn a_command_is_compared_with_the_one_before() {
    let task = task(&term("abs(right_command - right_previous_command)"));
    let (_, outcomes) = steps(&task, &[[0.5, 0.0], [0.5, 0.0], [-0.25, 0.0], [7.0, 0.0]]);
    let own: Vec<f64> = outcomes.iter().map(|o| o.terms.extra[0]).collect();
    // Nothing precedes the first; what lies beyond 1 is limited to it.
    assert_eq!(own, [0.0, 0.0, 1.5, 2.5]);
}

#[test]
fn works_of_the_period_add_up_to_those_of_the_episode() {
    let task = task(&term("period_positive_work_j"));
    let (environment, outcomes) = steps(&task, &[[0.4, -0.3]; 20]);
    let sum: f64 = outcomes.iter().map(|o| o.terms.extra[0] / 2.0).sum();
    let whole = environment.account.positive_work();
    assert!(whole > 1.0 && (sum - whole).abs() < 1e-9 * whole);
}

#[test]
fn a_rule_ends_the_episode_as_a_fall_under_its_name() {
    let task = task(&(rule("late", "time_s > 0.045") + &rule("later", "time_s > 0.05")));
    task.validate(&BodyParameters::default()).unwrap();
    let (_, outcomes) = steps(&task, &[[0.0; 2]; 5]);
    let ended: Vec<Option<EndReason>> = outcomes.iter().map(|o| o.ended).collect();
    assert_eq!(ended[..4], [None; 4]);
    let reason = ended[4].unwrap();
    assert!(reason.is_termination() && !reason.is_failure());
    assert_eq!(task.end_name(reason), "late");
    assert_eq!(task.end_name(EndReason::Pitch), "pitch");
}

#[test]
fn what_is_not_finite_at_the_start_is_refused() {
    let refused = |text: &str, parts: &[&str]| {
        let error = task(text).validate(&BodyParameters::default()).unwrap_err();
        for part in parts {
            assert!(error.to_string().contains(part), "{error}");
        }
    };
    refused(
        &term("1 / omega_v"),
        &[
            "`task.reward.extra[0].expression`",
            "1 / omega_v",
            "division by zero",
            "default start",
        ],
    );
    refused(
        &rule("odd", "sqrt(z_m - 5) > 1"),
        &["`task.termination.extra[0].expression`", "domain"],
    );
}

#[test]
fn what_is_not_finite_later_fails_the_step() {
    // Finite at the start, where time is 0; a domain error from 0.03 s on.
    for text in [
        term("sqrt(0.025 - time_s)"),
        rule("odd", "sqrt(0.025 - time_s) < 0"),
    ] {
        let task = task(&text);
        task.validate(&BodyParameters::default()).unwrap();
        let (_, outcomes) = steps(&task, &[[0.0; 2]; 3]);
        assert_eq!([outcomes[0].ended, outcomes[1].ended], [None, None]);
        let last = outcomes[2];
        assert_eq!(last.ended, Some(EndReason::Undefined));
        assert!(EndReason::Undefined.is_failure() && EndReason::Undefined.is_termination());
        assert_eq!(last.terms.sum(), 0.0);
        assert_eq!(task.end_name(EndReason::Undefined), "undefined");
    }
}

#[test]
fn names_and_weights_are_checked() {
    let refused = |text: &str, part: &str| {
        let error = toml::from_str::<TaskParameters>(text)
            .unwrap_err()
            .to_string();
        assert!(error.contains(part), "{error}");
    };
    let named = |name: &str| term("1").replace("own", name);
    refused(&named("energy"), "reserved");
    refused(&named("Upright"), "lower-case");
    refused(&named("a b"), "lower-case");
    refused(&named(""), "lower-case");
    refused(
        &(term("1") + &term("2")),
        "two of the reward terms are named `own`",
    );
    refused(&term("1").replace("2.0", "inf"), "finite");
    refused(&term("1").replace("weight", "wait"), "unknown field `wait`");
    refused(&rule("pitch", "1"), "reserved");
    let many: String = (0..9).map(|k| named(&format!("own{k}"))).collect();
    refused(&many, "8 is the most");
}

#[test]
fn phases_replace_and_move_the_weight() {
    let task = task(&term("1"));
    let phase = |text: &str| toml::from_str::<Phase>(text).unwrap();
    let curriculum = Curriculum {
        phases: vec![
            phase("name = 'a'\nsteps = 100\nomega_v = [0, 1]"),
            phase(
                "name = 'b'\nsteps = 100\nomega_v = [0, 1]\nreward_extra = { own = 1 }\nreward_extra_end = { own = 3 }",
            ),
        ],
        ..Curriculum::default()
    };
    let body = BodyParameters::default();
    curriculum.validate(&body, &task.reward).unwrap();
    let own = |step: u64| {
        let mut reward = curriculum.at(step, &task.reward).reward;
        *reward.extra.weight_mut("own").unwrap()
    };
    assert_eq!([own(0), own(100), own(150), own(200)], [2.0, 1.0, 2.0, 3.0]);
    let error = curriculum
        .validate(&body, &TaskParameters::default().reward)
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("curriculum.phases[1].reward_extra.own"),
        "{error}"
    );
}

#[test]
fn mirrored_states_are_worth_the_same() {
    let task = task(&term(
        "-(right_phi_rad + left_phi_rad)^2 + right_command * left_command - period_energy_change_j / 100",
    ));
    let body = body();
    let start = Environment::default_start(&body, &task);
    let mut one = Environment::new(&body, start, 0.5);
    let mut other = Environment::new(&body, start.mirrored(), 0.5);
    for step in 0..50 {
        let (a, b) = (0.3 * f64::from(step % 3), -0.2);
        let first = one.step(&body, &task, &task.reward, [a, b]);
        let second = other.step(&body, &task, &task.reward, [b, a]);
        let (first, second) = (first.terms.extra[0], second.terms.extra[0]);
        assert!((first - second).abs() <= 1e-12 * (1.0 + first.abs()));
    }
}

#[test]
fn other_learners_are_told_the_term() {
    let task = task(&term("omega_v + time_s"));
    let mut names = info_names(&task.reward);
    assert_eq!(names.pop().as_deref(), Some("reward_own"));
    assert_eq!(names, info_names(&TaskParameters::default().reward));
    let place = names.len();
    let mut vector = VectorEnvironment::new(body(), task, [1.0, 1.0], 2);
    let opening = Opening {
        default_start: true,
        ..Opening::default()
    };
    assert_eq!(vector.reset(0, opening).info[place], 0.0);
    assert_eq!(vector.step(0, [0.1, 0.1]).info[place], 2.0 * 1.01);
}

#[test]
fn a_batch_that_is_saved_and_restored_goes_on_alike() {
    let task =
        task(&(term("-abs(left_command - left_previous_command)") + &rule("low", "z_m < 0.8")));
    let settings = Curriculum::default().at(0, &task.reward);
    let mut batch = EnvironmentBatch::new(body(), task, 2, 3, &settings);
    let run = |batch: &mut EnvironmentBatch| -> Vec<f64> {
        let step = |k: i32| {
            let command = [(f64::from(k) * 0.7).sin(), (f64::from(k) * 0.9).cos()];
            let (outcome, finished) = batch.step(0, command, 0.0, &settings);
            if finished.is_some() {
                batch.reset(0, &settings);
            }
            outcome.terms.sum()
        };
        (0..300).map(step).collect()
    };
    run(&mut batch);
    let text = serde_json::to_string(&batch.state()).unwrap();
    let first = run(&mut batch);
    assert!(batch.restore(serde_json::from_str(&text).unwrap()));
    assert_eq!(run(&mut batch), first);
}
