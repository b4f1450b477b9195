//! Contract: a study has what its plan asks for: every command, both ways of the stairs, every start and phase, heights and levels
//! until none is passed; a fall ends a stair, not the stairs. What was measured of a run is kept in its folder, and used again only for the same controller and plan.

use crate::common::{run, tiny};
use gaitshift_analysis::GaitClass::{Fallen, Running, Walking};
use gaitshift_report::{Measured, Plan, ReportError, Study, Subject};

#[test]
fn a_study_has_what_its_plan_asks_for() {
    let plan = Plan {
        range: [0.0, 3.0, 1.0],
        ..tiny()
    };
    let mut subject = Subject::shipped().unwrap();
    let usual_s = subject.body.parameters().time_step_s;
    let mut told = Vec::new();
    let measured = Measured::measure(&mut subject, &plan, &mut |what| {
        told.push(what.to_owned());
        Ok(())
    });
    let Measured { study, traces, .. } = measured.unwrap();
    assert!(told.contains(&"steady motions".to_owned()));
    assert_eq!(subject.body.parameters().time_step_s, usual_s);

    let commands: Vec<f64> = study.steady.iter().map(|row| row.omega_v).collect();
    assert_eq!(commands, [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(study.at(0.0).unwrap().gait, Walking);
    assert_eq!(study.at(3.0).unwrap().gait, Running);
    assert!(study.at(0.5).is_none());
    // The same motions, as long as the usual ones, with the finer step.
    let fine = study.fine_step.as_ref().unwrap();
    assert_eq!(fine.time_step_s, plan.fine_step_s);
    assert_eq!(fine.steady.len(), 4);
    for (usual, fine) in study.steady.iter().zip(&fine.steady) {
        assert_eq!(usual.omega_v, fine.omega_v);
        assert_eq!(usual.summary.survived_s, fine.summary.survived_s);
        assert_ne!(usual.summary.froude, fine.summary.froude);
    }
    assert_eq!(
        (
            fine.stairs_up.len(),
            fine.stairs_down.len(),
            fine.starts.len()
        ),
        (3, 3, 6)
    );
    assert_eq!(fine.landings.len(), 1);

    let stairs = |rows: &[gaitshift_report::Steady]| -> Vec<f64> {
        rows.iter().map(|row| row.omega_v).collect()
    };
    assert_eq!(stairs(&study.stairs_up), [0.0, 0.3, 0.6]);
    assert_eq!(stairs(&study.stairs_down), [0.6, 0.3, 0.0]);
    // Three commands, two starts each.
    let starts: Vec<(f64, u64)> = study.starts.iter().map(|m| (m.omega_v, m.seed)).collect();
    let expected = [0.0, 0.3, 0.6].map(|w| [(w, 1), (w, 2)]).concat();
    assert_eq!(starts, expected);

    assert_eq!((study.to_running.len(), study.to_walking.len()), (2, 2));
    assert!(study.to_running.iter().all(|c| c.leads(Walking, Running)));
    assert_eq!(study.journal_changes.each_ref().map(Vec::len), [2, 2]);
    assert_eq!(study.walk_run_walk, [Walking, Running, Walking]);
    assert_eq!(study.round_trip.len(), 2);

    // Of each kind the heights grow, and after one that is passed nowhere none is tried.
    for kind in study.step_heights.chunk_by(|a, b| {
        (a.omega_v, a.by_turns, a.height_m > 0.0) == (b.omega_v, b.by_turns, b.height_m > 0.0)
    }) {
        assert!(
            kind.windows(2)
                .all(|w| w[0].height_m.abs() < w[1].height_m.abs())
        );
        let (last, before) = kind.split_last().unwrap();
        assert!(before.iter().all(|row| row.successes > 0));
        assert!(last.successes == 0 || last.height_m.abs() > 0.0039);
    }
    // Eight observations in either gait, at one level.
    assert_eq!(study.noise.len(), 16);
    assert!(
        study
            .noise
            .iter()
            .all(|row| row.deviation > 0.0 && row.trials == 2)
    );

    let followed: Vec<f64> = traces.iter().map(|(omega_v, _)| *omega_v).collect();
    assert_eq!(followed, plan.followed);
    assert_eq!(study.landings.len(), 2);
    for landing in &study.landings {
        assert!(landing.sole_down_m_per_s > 0.0 && landing.peak_body_weights > 1.0);
    }
    assert_eq!(study.late_falls, None);
}

// The shipped controller fell halfway up the stairs, and the study had no stairs above and no way down.
#[test]
fn a_fall_on_a_stair_is_recorded_and_a_fresh_motion_begins_on_the_next() {
    let mut subject = Subject::shipped().unwrap();
    // It leans further than this whatever it does.
    subject.controller.task.termination.pitch_limit_rad = 0.02;
    let plan = Plan {
        range: [0.0, 3.0, 3.0],
        ..tiny()
    };
    let measured = Measured::measure(&mut subject, &plan, &mut |_| Ok(())).unwrap();
    let study = measured.study;
    for (rows, commands) in [
        (&study.stairs_up, [0.0, 0.3, 0.6]),
        (&study.stairs_down, [0.6, 0.3, 0.0]),
    ] {
        let found: Vec<f64> = rows.iter().map(|row| row.omega_v).collect();
        assert_eq!(found, commands);
        for row in rows {
            assert_eq!((row.summary.gait, row.summary.fell), (Fallen, true));
            assert!((0.0..15.0).contains(&row.summary.survived_s));
            // What leads to a fall is no steady motion.
            assert_eq!(
                (row.summary.speed_m_per_s, row.energy_change_j),
                (None, None)
            );
        }
    }
    // The same command falls after the same time, whichever way it was reached: every stair began anew.
    let lasted = |rows: &[gaitshift_report::Steady]| -> Vec<f64> {
        rows.iter().map(|row| row.summary.survived_s).collect()
    };
    let down: Vec<f64> = lasted(&study.stairs_down).into_iter().rev().collect();
    assert_eq!(lasted(&study.stairs_up), down);
}

#[test]
fn what_was_measured_of_a_run_is_kept_in_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path());
    let plan = Plan {
        range: [0.0, 3.0, 3.0],
        followed: vec![3.0],
        step_heights_m: [0.002, 0.002, 0.002],
        ..tiny()
    };
    let measure = |plan: &Plan| {
        let mut again = false;
        let mut subject = Subject::read(&run).unwrap();
        let study = Study::measure(&mut subject, plan, &mut |what| {
            again |= what == "steady motions";
            Ok(())
        });
        (study.unwrap(), again)
    };
    let (study, again) = measure(&plan);
    assert!(again);
    assert_eq!(study.late_falls, Some(1.0 / 3.0));
    // To the last bit, without moving a leg.
    let (kept, again) = measure(&plan);
    assert!(!again && kept == study);
    // The figures' motions alone are made anew, the numbers stay.
    let mut subject = Subject::read(&run).unwrap();
    let mut told = Vec::new();
    let measured = Measured::measure(&mut subject, &plan, &mut |what| {
        told.push(what.to_owned());
        Ok(())
    });
    assert!(
        measured.unwrap().study == study && told.len() == 1,
        "{told:?}"
    );
    // The log of the training is read anew.
    std::fs::remove_file(run.join("episodes.csv")).unwrap();
    let (without, again) = measure(&plan);
    assert!(!again && without.late_falls.is_none());

    let shorter = Plan {
        steady_s: 11.0,
        ..plan.clone()
    };
    assert!(measure(&shorter).1, "another plan");
    let mut controller = subject.controller.clone();
    controller.provenance.seed += 1;
    controller
        .write(&run.join("controller.safetensors"))
        .unwrap();
    assert!(measure(&plan).1, "another controller");
    for file in std::fs::read_dir(&run).unwrap() {
        let path = file.unwrap().path();
        if path.to_string_lossy().contains("measured-") {
            std::fs::write(path, "{").unwrap();
        }
    }
    assert!(measure(&plan).1, "a damaged file");
}

#[test]
fn measuring_stops_when_it_is_told_to() {
    let mut subject = Subject::shipped().unwrap();
    let mut said = 0;
    let stopped = Measured::measure(&mut subject, &tiny(), &mut |_| {
        said += 1;
        if said == 2 {
            Err(ReportError::Stopped)
        } else {
            Ok(())
        }
    });
    assert!(matches!(stopped, Err(ReportError::Stopped)));
    assert_eq!(said, 2);
}

#[test]
fn a_run_is_tried_at_commands_that_it_was_trained_with() {
    let plan = Plan {
        range: [0.0, 3.0, 3.0],
        followed: vec![],
        step_heights_m: [0.002, 0.002, 0.002],
        noise_levels: vec![],
        ..tiny()
    };
    let mut subject = Subject {
        trained: Some([0.0, 2.5]),
        ..Subject::shipped().unwrap()
    };
    let study = Study::measure(&mut subject, &plan, &mut |_| Ok(())).unwrap();
    assert_eq!(study.gaits, [0.0, 2.5]);
    assert!(study.step_heights.iter().any(|row| row.omega_v == 2.5));
    assert!(study.step_heights.iter().all(|row| row.omega_v < 3.0));
}
