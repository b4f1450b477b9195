//! Contract: a stance lasts from a twentieth of the weight to a hundredth, 80 ms or longer, gaps under 20 ms filled; what a trace
//! begins or ends with is a contact, but no stance; a trace has a row for every integration step.

use gaitshift_report::{Subject, Trace, TraceRow};

/// Rows of a millisecond whose right foot bears these shares of a weight of 100 N for so many milliseconds.
fn trace(parts: &[(f64, usize)]) -> Trace {
    let forces = parts
        .iter()
        .flat_map(|&(share, count)| std::iter::repeat_n(100.0 * share, count));
    let row = |(k, force): (usize, f64)| TraceRow {
        time_s: 1e-3 * k as f64,
        normal_n: [force, 0.0],
        tangential_n: [0.0; 2],
        axial_n: [0.0; 2],
        length_m: [0.0; 2],
        sole_m_per_s: [[0.0; 2]; 2],
        com_z_m: 0.0,
        energies_j: [0.0; 4],
    };
    Trace {
        rows: forces.enumerate().map(row).collect(),
        fell: false,
    }
}

/// First rows of the right foot's stances, and the rows after their last.
fn stances(trace: &Trace) -> Vec<(usize, usize)> {
    let stances = trace.stances(0, 100.0);
    stances.iter().map(|s| (s.start, s.end)).collect()
}

#[test]
fn stances_begin_and_end_at_their_thresholds() {
    // It is not down at 4 %, down from 6 %, and still down at 2 %.
    let one = trace(&[(0.0, 50), (0.04, 10), (0.06, 100), (0.02, 30), (0.01, 50)]);
    assert_eq!(stances(&one), [(60, 190)]);
    assert!(one.stances(1, 100.0).is_empty());
}

#[test]
fn short_gaps_are_filled_and_short_contacts_left_out() {
    let gaps = trace(&[(0.0, 50), (1.0, 60), (0.0, 15), (1.0, 60), (0.0, 50)]);
    assert_eq!(stances(&gaps), [(50, 185)]);
    let apart = trace(&[(0.0, 50), (1.0, 90), (0.0, 25), (1.0, 60), (0.0, 50)]);
    assert_eq!(stances(&apart), [(50, 140)]);
}

#[test]
fn what_a_trace_begins_or_ends_with_is_a_contact_and_no_stance() {
    let cut = trace(&[(1.0, 20), (0.0, 50), (1.0, 100), (0.0, 50), (1.0, 20)]);
    assert_eq!(stances(&cut), [(70, 170)]);
    assert_eq!(cut.contacts(0, 100.0), [0..20, 70..170, 220..240]);
}

#[test]
fn a_trace_has_a_row_for_every_integration_step() {
    let mut subject = Subject::shipped().unwrap();
    let dt = subject.body.parameters().time_step_s;
    let trace = Trace::follow(&mut subject, 0.0, 1.0, 1.5).unwrap();
    assert!(!trace.fell);
    assert_eq!(trace.rows.len(), (0.5 / dt).round() as usize);
    assert!((trace.rows[0].time_s - 1.0).abs() < 1e-9);
    for pair in trace.rows.windows(2) {
        assert!((pair[1].time_s - pair[0].time_s - dt).abs() < 1e-9);
    }
}
