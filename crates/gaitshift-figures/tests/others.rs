mod common;
use gaitshift_figures::*;

#[test]
fn sample() {
    let r = common::transition();
    let f = strobe(&r, 0.8, 1.85, 9).unwrap();
    common::keep("strobe_walk.png", &f.to_png(2.0).unwrap());
    let f = strobe(&r, 4.0, 4.7, 9).unwrap();
    common::keep("strobe_run.png", &f.to_png(2.0).unwrap());
    let n = 9000;
    let (mut s, mut g, mut w) = (vec![], vec![], vec![]);
    let mut u = 12345u64;
    let mut rnd = || {
        u = u
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (u >> 33) as f64 / (1u64 << 31) as f64
    };
    for i in 0..n {
        let t = i as f64 / n as f64 * 1e7;
        s.push(t);
        let o = if t < 4.5e6 {
            -0.2 + 0.4 * rnd()
        } else {
            -0.5 + 4.0 * rnd()
        };
        w.push(o);
        g.push(
            (1.0 - (-t / 1.5e6).exp())
                * (800.0 + o * 900.0)
                * if rnd() < 0.2 { rnd() } else { 1.0 }
                + 60.0 * rnd(),
        );
    }
    let f = episode_returns_figure(&s, &g, &w).unwrap();
    common::keep("returns.png", &f.to_png(2.0).unwrap());
    common::keep("returns.svg", f.svg.as_bytes());
    let series: Vec<_> = [("seed 1", 0.0), ("seed 2", 0.07)]
        .iter()
        .map(|(l, d)| SweepSeries {
            label: l.to_string(),
            points: (0..8)
                .map(|i| {
                    let o = i as f64 * 0.5;
                    let fr = 0.2 + 0.24 * o + d;
                    SweepPoint {
                        omega_v: o,
                        fell: i == 7 && *d > 0.0,
                        speed_m_per_s: Some(fr * 2.8),
                        froude: Some(fr),
                        cost_of_transport: (i != 2).then_some(0.3 + d + 0.02 * o),
                        double_support: Some((0.4 - 0.3 * o).max(0.0)),
                        single_support: Some(0.6),
                        flight: Some((0.2 * o - 0.2).max(0.0)),
                    }
                })
                .collect(),
        })
        .collect();
    let f = sweep_figure(&series).unwrap();
    common::keep("sweep.png", &f.to_png(2.0).unwrap());
}
