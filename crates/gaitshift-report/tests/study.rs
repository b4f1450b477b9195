//! Contract: a study has what its plan asks for: every command, both ways of the stairs, every start and phase, heights and levels
//! until none is passed; the finer step is put back.

mod common;
use common::tiny;
use gaitshift_analysis::GaitClass::{Running, Walking};
use gaitshift_report::{Measured, Plan, Subject};

#[test]
fn a_study_has_what_its_plan_asks_for() {
    let plan = Plan {
        range: [0.0, 3.0, 1.0],
        ..tiny()
    };
    let mut subject = Subject::shipped().unwrap();
    let usual_s = subject.body.parameters().time_step_s;
    let mut told = Vec::new();
    let measured = Measured::measure(&mut subject, &plan, &mut |what| told.push(what.to_owned()));
    let Measured { study, traces, .. } = measured.unwrap();
    assert_eq!(told[0], "steady motions");
    assert_eq!(subject.body.parameters().time_step_s, usual_s);

    let commands: Vec<f64> = study.steady.iter().map(|row| row.omega_v).collect();
    assert_eq!(commands, [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(study.at(0.0).unwrap().gait, Walking);
    assert_eq!(study.at(3.0).unwrap().gait, Running);
    assert!(study.at(0.5).is_none());
    // 0, 0.5 ... 3.5, whatever the range.
    assert_eq!(study.fine_step.len(), 8);
    assert!(
        study
            .fine_step
            .iter()
            .all(|row| row.energy_change_j > Some(0.0))
    );

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
