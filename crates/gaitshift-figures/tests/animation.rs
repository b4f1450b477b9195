mod common;
use gaitshift_figures::*;

#[test]
fn sample() {
    let r = common::transition();
    let start = std::time::Instant::now();
    let f = animate(
        &r,
        &AnimationOptions {
            to_s: Some(6.0),
            ..Default::default()
        },
    )
    .unwrap();
    eprintln!("{} bytes {:?}", f.len(), start.elapsed());
    common::keep("transition.gif", &f);
}
