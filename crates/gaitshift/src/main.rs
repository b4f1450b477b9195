//! The program.
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut e = gaitshift_experiment::Experiment::load(&args[1]).unwrap_or_else(|e| {
        eprintln!("{e}");
        std::process::exit(2)
    });
    e.seed = args[3].parse().unwrap();
    struct O;
    impl gaitshift_experiment::Observer for O {
        fn progress(&mut self, p: &gaitshift_experiment::Progress) {
            if p.step % 100_000 < 2_100 {
                println!(
                    "{} {:.0}/s ret {:.0} fall {:.2} t {:.0}",
                    p.step,
                    p.step as f64 / p.elapsed_s,
                    p.mean_return,
                    p.fall_share,
                    p.elapsed_s
                );
            }
        }
        fn evaluated(
            &mut self,
            p: &gaitshift_experiment::Progress,
            j: &gaitshift_experiment::Judgement,
            best: bool,
        ) {
            println!(
                "EVAL {} score {:.2} {} {}",
                p.step,
                j.score(),
                if best { "BEST" } else { "" },
                p.verdict
            );
        }
        fn stop_requested(&self) -> bool {
            false
        }
    }
    let mut t = gaitshift_experiment::Training::new(e, std::path::Path::new(&args[2]), "dev")
        .unwrap_or_else(|e| {
            eprintln!("{e}");
            std::process::exit(2)
        });
    match t.run(&mut O) {
        Ok(r) => println!("{r:?}"),
        Err(e) => {
            eprintln!("{e}");
            std::process::exit(1)
        }
    }
}
