//! Look.
use gaitshift_report::{Plan, Subject, write_report};
fn main() {
    let mut a = std::env::args().skip(1);
    let out = a.next().unwrap();
    let mut subjects: Vec<Subject> = a
        .enumerate()
        .map(|(k, p)| {
            let mut s = Subject::read(p.as_ref()).unwrap();
            s.group = ["paper", "paper, without phase I"][usize::from(k > 2)].to_owned();
            s.seed = k as u64;
            s
        })
        .collect();
    let plan = Plan { range: [-0.5, 3.5, 0.1], stairs: [0.4, 0.4, 8.0], starts: 1, starts_step: 0.4, trials: 1, phases: 1,
        step_heights_m: [0.002, 0.004, 0.002], noise_levels: vec![0.5], followed: vec![0.0], ..Plan::quick() };
    println!("{:?}", write_report(&mut subjects, &plan, out.as_ref(), &mut |_| {}).is_ok());
}
