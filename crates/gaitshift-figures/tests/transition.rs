mod common;
use gaitshift_figures::*;

#[test]
fn sample() {
    let r = common::transition();
    let f = transition_figure(&r, (3.0, 3.4), &FigureOptions::default()).unwrap();
    common::keep("transition.svg", f.svg.as_bytes());
    common::keep("transition.png", &f.to_png(2.0).unwrap());
}
