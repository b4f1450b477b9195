//! Contract: a disturbance delays commands by exactly its latency, weakens each actuator by its factor, pushes the hip with
//! its impulse between the integration steps that its times say, and adds noise of the given size that its seed repeats;
//! what is out of range is named.

use gaitshift_body::{Body, BodyParameters};
use gaitshift_task::{
    Disturbance, Disturbed, Environment, OBSERVATION_NAMES, Push, SensorNoise, TaskParameters,
};

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

/// The body in the air, where no contact hides a force, after so many periods under commands that change.
fn flight(disturbance: &Disturbance, periods: u32) -> Environment {
    let (body, task) = (body(), TaskParameters::default());
    let mut state = Environment::default_start(&body, &task);
    state.z += 20.0;
    let mut environment = Environment::new(&body, state, 1.0);
    let mut disturbed = Disturbed::new(disturbance, body.parameters(), 1);
    for k in 0..periods {
        let command = command(k);
        match &mut disturbed {
            Some(disturbed) => {
                disturbed.step(&mut environment, &body, &task, &task.reward, command, None)
            }
            None => environment.step(&body, &task, &task.reward, command),
        };
    }
    environment
}

fn command(k: u32) -> [f64; 2] {
    let wave = (0.7 * f64::from(k)).sin();
    [0.5 * wave, -0.3 * wave]
}

#[test]
fn what_is_none_disturbs_nothing() {
    let none = Disturbance::default();
    assert!(none.is_none() && Disturbed::new(&none, body().parameters(), 1).is_none());
    // At work without effect, it moves the body to the same bits.
    let idle = Disturbance {
        pushes: vec![Push {
            start_s: 100.0,
            forward_n: 1.0,
            ..Push::default()
        }],
        ..none.clone()
    };
    assert_eq!(flight(&idle, 20), flight(&none, 20));
}

#[test]
fn a_push_gives_its_impulse_when_it_should() {
    let (body, none) = (body(), Disturbance::default());
    // Neither begin nor end falls on a control period: 0.0314 s to 0.0848 s.
    let push = Push {
        forward_n: 80.0,
        up_n: -30.0,
        start_s: 0.0314,
        duration_s: 0.0534,
        phase: None,
    };
    let pushed = Disturbance {
        pushes: vec![push, push],
        ..none.clone()
    };
    assert_eq!(flight(&pushed, 3), flight(&none, 3));
    assert_ne!(flight(&pushed, 4), flight(&none, 4));
    let momentum = |d: &Disturbance| body.momentum(&flight(d, 12).state);
    let (with, without) = (momentum(&pushed), momentum(&none));
    let impulse = 2.0 * 0.0534;
    assert!(
        (with.x - without.x - 80.0 * impulse).abs() < 0.05,
        "{}",
        with.x - without.x
    );
    assert!((with.z - without.z + 30.0 * impulse).abs() < 0.05);
    // A push at a phase of the stride comes in a stride only.
    let phased = Disturbance {
        pushes: vec![Push {
            phase: Some(0.5),
            ..push
        }],
        ..none.clone()
    };
    assert_eq!(flight(&phased, 12), flight(&none, 12));
}

#[test]
fn a_weak_actuator_is_one_of_so_much_less_force() {
    let d = Disturbance {
        actuator_factor: [0.5, 1.0],
        ..Disturbance::default()
    };
    let (body, task) = (body(), TaskParameters::default());
    let start = Environment::default_start(&body, &task);
    let mut weak = Environment::new(&body, start, 1.0);
    let mut disturbed = Disturbed::new(&d, body.parameters(), 1).unwrap();
    let outcome = disturbed.step(&mut weak, &body, &task, &task.reward, [1.0, 1.0], None);
    assert_eq!(outcome.report.actuator_n, [300.0, 600.0]);
    // What lies beyond the range of a command is limited before it is weakened.
    let outcome = disturbed.step(&mut weak, &body, &task, &task.reward, [-9.0, -9.0], None);
    assert_eq!(outcome.report.actuator_n, [-300.0, -600.0]);
}

#[test]
fn latency_shifts_commands_by_whole_steps() {
    let late = Disturbance {
        latency_s: 0.013,
        ..Disturbance::default()
    };
    let (body, task) = (body(), TaskParameters::default());
    let mut alone = flight(&Disturbance::default(), 0);
    let dt = body.parameters().time_step_s;
    let shift = (0.013 / dt).round() as u32;
    let period = task.steps_per_period(body.parameters());
    for step in 0..8 * period {
        let given = step
            .checked_sub(shift)
            .map_or([0.0; 2], |s| command(s / period));
        body.advance(&mut alone.state, given, 1, &mut alone.account);
    }
    let disturbed = flight(&late, 8);
    let (a, b) = (alone.state.positions(), disturbed.state.positions());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

// What is told as present acts: a latency below half a step was rounded to none.
#[test]
fn the_shortest_latency_and_push_last_one_step() {
    let step_s = body().parameters().time_step_s;
    let late = |latency_s| Disturbance {
        latency_s,
        ..Disturbance::default()
    };
    let shares = [0.0, 1e-9, 0.4, 1.4, 1.6].map(|steps| late(steps * step_s).latency_steps(step_s));
    assert_eq!(shares, [0, 1, 1, 1, 2]);
    let pushed = |duration_s| Disturbance {
        pushes: vec![Push {
            forward_n: 50.0,
            start_s: 0.0,
            duration_s,
            ..Push::default()
        }],
        ..Disturbance::default()
    };
    let moved = |d: &Disturbance| flight(d, 2).state.positions();
    assert_eq!(moved(&pushed(0.1 * step_s)), moved(&pushed(step_s)));
    assert_ne!(moved(&pushed(step_s)), moved(&Disturbance::default()));
}

#[test]
fn noise_has_its_size_and_is_repeated_by_its_seed() {
    let mut noise = SensorNoise::default();
    *noise.named_mut("theta_velocity_rad_per_s").unwrap() = 0.2;
    *noise.named_mut("phi_rad").unwrap() = 0.05;
    let d = Disturbance {
        noise,
        ..Disturbance::default()
    };
    let (body, task) = (body(), TaskParameters::default());
    let errors = |seed: u64| {
        let mut environment = flight(&Disturbance::default(), 0);
        let mut disturbed = Disturbed::new(&d, body.parameters(), seed).unwrap();
        let mut errors = Vec::new();
        for _ in 0..200 {
            let told = disturbed.observation(&environment);
            let (told, true_) = (told, environment.observation());
            errors.push(std::array::from_fn::<f64, 14, _>(|i| told[i] - true_[i]));
            disturbed.step(&mut environment, &body, &task, &task.reward, [0.0; 2], None);
        }
        errors
    };
    let drawn = errors(4);
    assert_eq!(drawn, errors(4));
    assert_ne!(drawn, errors(5));
    for (i, name) in OBSERVATION_NAMES.iter().enumerate() {
        let deviation = match *name {
            "theta_velocity_rad_per_s" => 0.2,
            "right_phi_rad" | "left_phi_rad" => 0.05,
            _ => 0.0,
        };
        let square: f64 = drawn.iter().map(|e| e[i] * e[i]).sum::<f64>() / 200.0;
        // The standard error of a deviation from 200 draws is 5 %: four of them.
        assert!(
            (square.sqrt() - deviation).abs() <= 0.2 * deviation,
            "{name}"
        );
    }
}

#[test]
fn what_is_out_of_range_is_named() {
    for (table, key) in [
        ("latency_s = 2", "latency_s"),
        ("actuator_factor = [1.5, 1]", "actuator_factor"),
        ("noise = { h_m = -1 }", "noise.h_m"),
        ("pushes = [{ forward_n = inf }]", "pushes[0].forward_n"),
        ("pushes = [{}, { phase = 1.0 }]", "pushes[1].phase"),
        ("pushes = [{ duration_s = -1 }]", "pushes[0].duration_s"),
        ("pushes = [{ duration_s = 0 }]", "pushes[0].duration_s"),
        ("terrain = { slope_rad = 1.5 }", "terrain.slope_rad"),
        (
            "terrain = { steps = [{ height_m = 3, at_m = 1 }] }",
            "terrain.steps[0].height_m",
        ),
        (
            "terrain = { uneven = { spacing_m = 0 } }",
            "terrain.uneven.spacing_m",
        ),
        (
            "terrain = { uneven = { spacing_m = 0.01, length_m = 1e4 } }",
            "terrain.uneven.length_m",
        ),
    ] {
        let disturbance: Disturbance = toml::from_str(table).unwrap();
        assert_eq!(disturbance.validate().unwrap_err().key, key, "{table}");
    }
    assert!(toml::from_str::<Disturbance>("latencey_s = 1").is_err());
    // Every one of them costs time in every control period.
    let pushes = |count| Disturbance {
        pushes: vec![Push::default(); count],
        ..Disturbance::default()
    };
    pushes(1000).validate().unwrap();
    assert_eq!(pushes(1001).validate().unwrap_err().key, "pushes");
}
