//! Contract: a phase that randomizes draws bodies within its ranges, delays commands by exactly the drawn time and
//! adds noise of the given size to what the controller sees, the same to the end of one step as to the beginning
//! of the next; a share of the episodes stays as it is; it pushes the hip as often, as hard and as long as asked for, weakens
//! each actuator, and puts the body on ground that is flat where episodes begin; a checkpoint holds what was drawn; values
//! out of range are named.

use gaitshift_body::{Body, BodyParameters, EnergyAccount};
use gaitshift_task::{
    BatchState, Curriculum, EnvironmentBatch, OBSERVATION_NAMES, OBSERVATION_SIZE, PhaseSettings,
    Randomization, RewardParameters, TaskParameters, observe,
};

fn settings(table: &str) -> PhaseSettings {
    let randomization: Randomization = toml::from_str(table).unwrap();
    PhaseSettings {
        randomization: Some(randomization),
        ..Curriculum::default().at(0, &TaskParameters::default().reward)
    }
}

fn batch(count: usize, settings: &PhaseSettings) -> EnvironmentBatch {
    let body = Body::new(BodyParameters::default()).unwrap();
    EnvironmentBatch::new(body, TaskParameters::default(), count, 5, settings)
}

#[test]
fn bodies_are_drawn_within_their_ranges_and_nothing_else_changes() {
    let settings = settings("body = { friction = [0.5, 1.5], stop_dissipation_s_per_m = [0, 1] }");
    let batch = batch(400, &settings);
    let base = BodyParameters::default();
    let mut means = [0.0; 2];
    for i in 0..batch.len() {
        let drawn = batch.body_of(i).parameters();
        let factors = [
            drawn.friction / base.friction,
            drawn.stop_dissipation_s_per_m / base.stop_dissipation_s_per_m,
        ];
        assert!((0.5..=1.5).contains(&factors[0]) && (0.0..=1.0).contains(&factors[1]));
        for (mean, factor) in means.iter_mut().zip(factors) {
            *mean += factor / batch.len() as f64;
        }
        let rest = BodyParameters {
            friction: base.friction,
            stop_dissipation_s_per_m: base.stop_dissipation_s_per_m,
            ..drawn.clone()
        };
        assert_eq!(rest, base);
    }
    // Standard errors are 0.014: four of them.
    assert!(
        (means[0] - 1.0).abs() < 0.06 && (means[1] - 0.5).abs() < 0.06,
        "{means:?}"
    );
}

#[test]
fn a_share_of_the_episodes_is_drawn_and_the_next_episode_draws_anew() {
    let settings = settings("share = 0.3\nbody = { hip_mass_kg = [1.1, 1.2] }");
    let mut batch = batch(1000, &settings);
    let drawn = |batch: &EnvironmentBatch| -> Vec<bool> {
        let base = batch.body().parameters();
        let own = (0..batch.len()).map(|i| batch.body_of(i).parameters() != base);
        own.collect()
    };
    let first = drawn(&batch);
    let share = first.iter().filter(|d| **d).count();
    assert!((240..=360).contains(&share), "{share} of 1000");
    for i in 0..batch.len() {
        batch.reset(i, &settings);
    }
    assert_ne!(drawn(&batch), first);
}

/// Runs a batch of one with commands that change every period, and beside it the body itself with those commands
/// shifted by `late` integration steps.
fn compare_delay(late: u32) {
    let dt = BodyParameters::default().time_step_s;
    let latency_s = f64::from(late) * dt;
    let settings = settings(&format!("latency_s = [{latency_s}, {latency_s}]"));
    let mut batch = batch(1, &settings);
    let body = Body::new(BodyParameters::default()).unwrap();
    let per_period = TaskParameters::default().steps_per_period(body.parameters());
    let mut state = batch.environment(0).state;
    let mut account = EnergyAccount::default();
    let command = |period: u32| [f64::from(period * 37 % 11) / 11.0 - 0.3, 0.5];
    for period in 0..12 {
        batch.step(0, command(period), 0.0, &settings);
        for step in 0..per_period {
            let held = match (period * per_period + step).checked_sub(late) {
                Some(given) => command(given / per_period),
                None => [0.0; 2],
            };
            body.advance(&mut state, held, 1, &mut account);
        }
        assert_eq!(
            batch.environment(0).state,
            state,
            "late by {late} steps, period {period}"
        );
    }
}

#[test]
fn commands_arrive_late_by_the_drawn_time() {
    for late in [0, 1, 20, 49, 50, 51, 130] {
        compare_delay(late);
    }
}

#[test]
fn forces_reported_are_means_over_the_period() {
    let settings = settings("latency_s = [0.004, 0.004]");
    let mut batch = batch(1, &settings);
    let (outcome, _) = batch.step(0, [1.0, 0.5], 0.0, &settings);
    // 6 of 10 ms under 600 N and 300 N.
    assert!((outcome.report.actuator_n[0] - 360.0).abs() < 1e-9);
    assert!((outcome.report.actuator_n[1] - 180.0).abs() < 1e-9);
}

#[test]
fn noise_has_its_size_and_stays_until_the_next_step() {
    let table = "noise = { x_velocity_m_per_s = 0.2, h_m = 0.01, phi_velocity_rad_per_s = 0.5 }";
    let settings = settings(table);
    let mut batch = batch(1, &settings);
    let mut squares = [0.0; OBSERVATION_SIZE];
    let count = 4000;
    for _ in 0..count {
        let (_, finished) = batch.step(0, [0.3, 0.3], 0.0, &settings);
        if finished.is_some() {
            batch.reset(0, &settings);
        }
        let omega_v = batch.environment(0).omega_v;
        let seen = batch.observation(0, omega_v);
        assert_eq!(seen, batch.observation(0, omega_v));
        let exact = observe(&batch.environment(0).state, omega_v);
        for ((square, seen), exact) in squares.iter_mut().zip(seen).zip(exact) {
            *square += (seen - exact).powi(2) / f64::from(count);
        }
    }
    for (name, square) in OBSERVATION_NAMES.iter().zip(squares) {
        let expected = match *name {
            "x_velocity_m_per_s" => 0.2,
            "right_h_m" | "left_h_m" => 0.01,
            "right_phi_velocity_rad_per_s" | "left_phi_velocity_rad_per_s" => 0.5,
            _ => 0.0,
        };
        assert!(
            (square.sqrt() - expected).abs() <= 0.05 * expected,
            "{name}: {}",
            square.sqrt()
        );
    }
}

#[test]
fn a_saved_batch_goes_on_to_the_same_bits() {
    let settings = settings(
        "share = 0.7\nlatency_s = [0, 0.015]\nbody = { hip_mass_kg = [0.8, 1.2] }\nnoise = { theta_rad = 0.01 }",
    );
    let run = |batch: &mut EnvironmentBatch, from: u32| {
        let mut seen = Vec::new();
        for step in from..from + 60 {
            for i in 0..batch.len() {
                let command = [(f64::from(step) * 0.3).sin(), 0.4];
                if batch.step(i, command, 0.0, &settings).1.is_some() {
                    batch.reset(i, &settings);
                }
                seen.push(batch.observation(i, 0.5));
            }
        }
        seen
    };
    let mut whole = batch(4, &settings);
    run(&mut whole, 0);
    let saved = serde_json::to_string(&whole.state()).unwrap();
    let mut other = batch(4, &settings);
    other.reset(1, &settings);
    let state: BatchState = serde_json::from_str(&saved).unwrap();
    assert!(other.restore(state));
    assert_eq!(run(&mut whole, 60), run(&mut other, 60));
}

#[test]
fn a_saved_body_that_cannot_be_is_refused() {
    let settings = settings("body = { hip_mass_kg = [1.1, 1.1] }");
    let mut batch = batch(1, &settings);
    let saved = serde_json::to_string(&batch.state()).unwrap();
    let bad = saved.replace("\"thigh_mass_kg\":6.0", "\"thigh_mass_kg\":-6.0");
    assert_ne!(saved, bad);
    assert!(!batch.restore(serde_json::from_str(&bad).unwrap()));
}

#[test]
fn values_out_of_range_are_named() {
    for (table, key) in [
        ("share = 1.5", "randomization.share"),
        ("latency_s = [0.02, 0.01]", "randomization.latency_s"),
        ("latency_s = [-0.01, 0.01]", "randomization.latency_s"),
        ("latency_s = [0.0, 3.0]", "randomization.latency_s"),
        (
            "body = { friction = [1.2, 0.8] }",
            "randomization.body.friction",
        ),
        (
            "body = { friction = [-0.5, 0.8] }",
            "randomization.body.friction",
        ),
        (
            "body = { hip_mass_kg = [0.0, 1.0] }",
            "randomization.body.hip_mass_kg",
        ),
        (
            "body = { k1_n_per_m = [1.0, inf] }",
            "randomization.body.k1_n_per_m",
        ),
        (
            "body = { tibia_distance_m = [0.0, 1.0] }",
            "randomization.body.tibia_distance_m",
        ),
        (
            "noise = { theta_rad = -0.1 }",
            "randomization.noise.theta_rad",
        ),
        ("noise = { h_m = nan }", "randomization.noise.h_m"),
    ] {
        let mut curriculum = Curriculum::default();
        curriculum.phases[1].randomization = Some(toml::from_str(table).unwrap());
        let error = curriculum
            .validate(&BodyParameters::default(), &RewardParameters::default())
            .unwrap_err();
        assert_eq!(
            error.key,
            format!("curriculum.phases[1].{key}"),
            "{table}: {error}"
        );
    }
    for (table, name) in [
        ("body = { leg_length_m = [0.9, 1.1] }", "leg_length_m"),
        ("noise = { omega_v = 0.1 }", "omega_v"),
        ("delay_s = [0, 0.1]", "delay_s"),
    ] {
        let error = toml::from_str::<Randomization>(table)
            .unwrap_err()
            .to_string();
        assert!(error.contains(name), "{error}");
    }
}

const HINDERED: &str = "actuator_factor = [0.6, 0.9]\n\
    pushes = { interval_s = 0.2, forward_n = [-60, 60], up_n = [5, 10], duration_s = [0.025, 0.05] }\n\
    terrain = { slope_rad = [-0.05, 0.05], slope_from_m = [1, 2], steps = { height_m = [-0.02, 0.02] }, \
    uneven = { height_m = [0.001, 0.01] } }";

#[test]
fn the_ground_is_drawn_for_every_episode_and_flat_where_it_begins() {
    let settings = settings(HINDERED);
    let batch = batch(60, &settings);
    let heights: Vec<f64> = (0..batch.len())
        .map(|i| {
            let body = batch.body_of(i);
            for x in [-5.0, -0.4, 0.0, 0.4] {
                assert_eq!(body.ground_height(x), 0.0);
            }
            // The feet of a start stand on it, above nothing else.
            let state = &batch.environment(i).state;
            assert!(state.z > 0.7 && state.z < 1.1, "{}", state.z);
            body.ground_height(20.0)
        })
        .collect();
    let most = heights.iter().fold(0.0_f64, |most, z| most.max(z.abs()));
    // 19 m at 0.05 rad, and what steps and unevenness add.
    assert!(most > 0.4 && most < 1.4, "{most}");
    let mut sorted = heights.clone();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    assert_eq!(sorted.len(), heights.len());
    assert!(sorted[0] < 0.0 && sorted[sorted.len() - 1] > 0.0);
}

#[test]
fn pushes_come_as_often_as_hard_and_as_long_as_asked_for() {
    // In weightless flight the momentum tells every push: nothing else moves the centre of mass.
    let settings = settings(
        "pushes = { interval_s = 0.25, up_n = [40, 40], duration_s = [0.035, 0.035] }\n\
         body = { gravity_m_per_s2 = [0, 0] }",
    );
    let mut task = TaskParameters::default();
    task.termination.time_limit_s = 1e6;
    task.termination.pitch_limit_rad = 1e6;
    let body = Body::new(BodyParameters::default()).unwrap();
    let mass = body.parameters().total_mass_kg();
    let mut batch = EnvironmentBatch::new(body, task, 20, 3, &settings);
    let (mut pushes, mut periods) = (0.0, 0.0);
    for i in 0..batch.len() {
        let momentum = |batch: &EnvironmentBatch| {
            let state = &batch.environment(i).state;
            mass * batch.body_of(i).centre_of_mass(state).z_dot
        };
        // The first pushes lift it off the ground.
        for _ in 0..300 {
            batch.step(i, [0.0; 2], 0.0, &settings);
        }
        let feet_off = |batch: &EnvironmentBatch| batch.environment(i).state.z > 1.2;
        if !feet_off(&batch) {
            continue;
        }
        let before = momentum(&batch);
        for _ in 0..500 {
            batch.step(i, [0.0; 2], 0.0, &settings);
        }
        pushes += (momentum(&batch) - before) / (40.0 * 0.035);
        periods += 500.0;
    }
    assert!(periods >= 1000.0, "{periods}");
    // A push lasts 4 control periods, in which none begins, and comes after 25 of them on average.
    let expected = periods / (25.0 + 4.0 - 1.0);
    let deviation = f64::sqrt(expected);
    assert!(
        (pushes - expected).abs() < 4.0 * deviation,
        "{pushes} {expected}"
    );
}

#[test]
fn the_work_of_a_push_is_no_part_of_the_reward() {
    let settings =
        settings("pushes = { interval_s = 0.01, forward_n = [500, 500], duration_s = [1, 1] }");
    let mut batch = batch(1, &settings);
    let mut plain = self::batch(1, &self::settings("share = 1"));
    let terms = |batch: &mut EnvironmentBatch| batch.step(0, [0.0; 2], 0.0, &settings).0.terms;
    let (pushed, free) = (terms(&mut batch), terms(&mut plain));
    let work = batch.environment(0).account.external_work;
    assert!(work.abs() > 1.0, "{work}");
    // 0.2 per J: the push's work would show.
    assert!((pushed.energy - free.energy).abs() < 0.02 * work.abs());
}

#[test]
fn actuators_are_weakened_each_by_itself() {
    let body = Body::new(BodyParameters::default()).unwrap();
    let work = |factor: &str| {
        let settings = settings(&format!("actuator_factor = {factor}"));
        let mut batch =
            EnvironmentBatch::new(body.clone(), TaskParameters::default(), 1, 5, &settings);
        let report = batch.step(0, [1.0, -7.0], 0.0, &settings).0.report;
        report.actuator_n
    };
    let whole = work("[1, 1]");
    assert_eq!(whole, [600.0, -600.0]);
    assert_eq!(work("[0.5, 0.5]"), [300.0, -300.0]);
    let drawn = work("[0.5, 0.8]");
    assert!(drawn[0] >= 300.0 && drawn[0] <= 480.0 && drawn[1] <= -300.0 && drawn[1] >= -480.0);
    assert_ne!(drawn[0], -drawn[1]);
}

#[test]
fn the_height_of_the_hips_centre_of_mass_is_drawn_from_its_range() {
    let settings = settings("hip_com_height_m = [-0.05, 0.1]");
    let batch = batch(400, &settings);
    let base = BodyParameters::default();
    let drawn = |i: usize| batch.body_of(i).parameters();
    let heights: Vec<f64> = (0..batch.len())
        .map(|i| drawn(i).hip_com_height_m)
        .collect();
    let (low, high) = heights.iter().fold((1.0_f64, -1.0_f64), |(low, high), &h| {
        (low.min(h), high.max(h))
    });
    assert!((-0.05..-0.045).contains(&low), "{low}");
    assert!((0.095..=0.1).contains(&high), "{high}");
    for (i, &height) in heights.iter().enumerate() {
        let rest = BodyParameters {
            hip_com_height_m: base.hip_com_height_m,
            ..drawn(i).clone()
        };
        assert_eq!(rest, base, "{height}");
    }
}

// Where the segments' centres of mass lie could not be drawn.
#[test]
fn the_segments_distances_are_drawn_where_asked_for_and_nothing_else_changes() {
    let before = "friction = [0.5, 1.5], tibia_inertia_kg_m2 = [0.8, 1.2]";
    let plain = settings(&format!("body = {{ {before} }}"));
    let plain = batch(200, &plain);
    let distances = "thigh_distance_m = [0.8, 1.2], tibia_distance_m = [0.8, 1.2], foot_distance_m = [0.8, 1.05]";
    let drawn = settings(&format!("body = {{ {before}, {distances} }}"));
    let drawn = batch(200, &drawn);
    let base = BodyParameters::default();
    let mut extremes = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for i in 0..drawn.len() {
        let body = drawn.body_of(i).parameters();
        let factors = [
            body.thigh_distance_m / base.thigh_distance_m,
            body.tibia_distance_m / base.tibia_distance_m,
            body.foot_distance_m / base.foot_distance_m,
        ];
        for ([low, high], factor) in extremes.iter_mut().zip(factors) {
            (*low, *high) = (low.min(factor), high.max(factor));
        }
        let rest = BodyParameters {
            thigh_distance_m: base.thigh_distance_m,
            tibia_distance_m: base.tibia_distance_m,
            foot_distance_m: base.foot_distance_m,
            ..body.clone()
        };
        // The body's other factors are those that the same episode draws without.
        assert_eq!(rest, *plain.body_of(i).parameters(), "{i}");
    }
    for ([low, high], range) in extremes
        .into_iter()
        .zip([[0.8, 1.2], [0.8, 1.2], [0.8, 1.05]])
    {
        let margin = 0.05 * (range[1] - range[0]);
        assert!(
            (range[0]..range[0] + margin).contains(&low),
            "{low} of {range:?}"
        );
        assert!(
            (range[1] - margin..=range[1]).contains(&high),
            "{high} of {range:?}"
        );
    }
}

#[test]
fn a_mirrored_state_moves_as_the_mirror_image_on_a_body_that_was_drawn() {
    let body = "body = { thigh_distance_m = [0.8, 1.2], foot_distance_m = [0.8, 1.05], thigh_inertia_kg_m2 = [0.8, 1.2] }";
    let batch = batch(5, &settings(body));
    for i in 0..batch.len() {
        let body = batch.body_of(i);
        let mut state = batch.environment(i).state;
        let mut mirrored = state.mirrored();
        let mut account = EnergyAccount::default();
        body.advance(&mut state, [0.7, -0.2], 500, &mut account);
        body.advance(&mut mirrored, [-0.2, 0.7], 500, &mut account);
        assert_eq!(mirrored, state.mirrored(), "{i}");
    }
}

#[test]
fn what_is_not_asked_for_is_drawn_as_before() {
    let table =
        "noise = { theta_rad = 0.01 }\nlatency_s = [0, 0.01]\nbody = { friction = [0.5, 1.5] }";
    let run = |more: &str| {
        let settings = settings(&format!("{table}\n{more}"));
        let mut batch = batch(3, &settings);
        let start = batch.state();
        let mut episodes = 0;
        for _ in 0..300 {
            for i in 0..3 {
                if batch.step(i, [0.4, -0.1], 0.0, &settings).1.is_some() {
                    batch.reset(i, &settings);
                    episodes += 1;
                }
            }
        }
        assert!(episodes >= 3, "{episodes}");
        (start, batch.state())
    };
    let plain = run("");
    // The whole of it, random numbers included, and over the starts of later episodes.
    assert_eq!(run("terrain = {}"), plain);
    // What is asked for takes numbers even where it changes nothing, and starts are drawn after it: the comparison tells.
    assert_ne!(run("actuator_factor = [1, 1]").0, plain.0);
}

#[test]
fn a_hindered_batch_goes_on_from_a_checkpoint_to_the_same_bits() {
    let settings = settings(HINDERED);
    let mut batch = batch(4, &settings);
    let run = |batch: &mut EnvironmentBatch| -> Vec<f64> {
        let mut told = Vec::new();
        for step in 0..400 {
            for i in 0..4 {
                let command = [f64::from(step % 7) / 7.0 - 0.4, 0.1 * i as f64];
                let (outcome, finished) = batch.step(i, command, 0.0, &settings);
                told.push(outcome.terms.sum());
                if finished.is_some() {
                    batch.reset(i, &settings);
                }
            }
        }
        told
    };
    run(&mut batch);
    let text = serde_json::to_string(&batch.state()).unwrap();
    let first = run(&mut batch);
    let state: BatchState = serde_json::from_str(&text).unwrap();
    assert!(batch.restore(state));
    assert_eq!(run(&mut batch), first);
    // A damaged ground is not gone on with.
    let damaged = text.replace("\"spacing_m\":0.25", "\"spacing_m\":1e-12");
    assert_ne!(damaged, text);
    assert!(!batch.restore(serde_json::from_str(&damaged).unwrap()));
}

#[test]
fn steps_as_far_away_as_they_may_be_are_gone_on_with_from_a_checkpoint() {
    // What went wrong: steps could be asked for so far away that the ground drawn from them was refused on resuming.
    let table = "terrain.steps = { height_m = [0.01, 0.02], spacing_m = [0.05, 1], from_m = 9960, length_m = 40 }";
    let settings = settings(table);
    let mut curriculum = Curriculum::default();
    curriculum.phases[1].randomization = settings.randomization.clone();
    curriculum
        .validate(&BodyParameters::default(), &RewardParameters::default())
        .unwrap();
    let mut batch = batch(20, &settings);
    let heights = (0..batch.len()).map(|i| batch.body_of(i).ground_height(10_000.0));
    assert!(heights.into_iter().all(|height| height > 0.3));
    let state = batch.state();
    assert!(batch.restore(state));
}

#[test]
fn ranges_of_ground_pushes_and_weakness_are_checked() {
    for (table, key) in [
        ("actuator_factor = [0.5, 1.2]", "actuator_factor"),
        ("hip_com_height_m = [0.1, -0.1]", "hip_com_height_m"),
        ("hip_com_height_m = [0, 3]", "hip_com_height_m"),
        ("pushes = { interval_s = 0 }", "pushes.interval_s"),
        ("pushes = { forward_n = [5, -5] }", "pushes.forward_n"),
        ("pushes = { duration_s = [-1, 0] }", "pushes.duration_s"),
        ("terrain = { slope_rad = [0, 1] }", "terrain.slope_rad"),
        (
            "terrain = { slope_from_m = [0, 1] }",
            "terrain.slope_from_m",
        ),
        (
            "terrain.steps = { height_m = [0, 2] }",
            "terrain.steps.height_m",
        ),
        (
            "terrain.steps = { spacing_m = [0, 2] }",
            "terrain.steps.spacing_m",
        ),
        ("terrain.steps = { from_m = 0 }", "terrain.steps.from_m"),
        ("terrain.steps = { from_m = 9990 }", "terrain.steps.from_m"),
        (
            "terrain.uneven = { height_m = [-1, 2] }",
            "terrain.uneven.height_m",
        ),
        (
            "terrain.uneven = { spacing_m = 0 }",
            "terrain.uneven.spacing_m",
        ),
        (
            "terrain.uneven = { length_m = 1e9 }",
            "terrain.uneven.length_m",
        ),
    ] {
        let mut curriculum = Curriculum::default();
        curriculum.phases[1].randomization = Some(toml::from_str(table).unwrap());
        let error = curriculum
            .validate(&BodyParameters::default(), &RewardParameters::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(&format!("curriculum.phases[1].randomization.{key}`")),
            "{error}"
        );
    }
    assert!(toml::from_str::<Randomization>("terrain = { slope = [0, 1] }").is_err());
}
