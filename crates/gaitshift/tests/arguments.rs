//! The command line: its help teaches every option, and whatever does not make sense is refused before
//! anything runs, with one error on standard error that names the option and says what is accepted.

use crate::common::Place;

const COMMANDS: [&str; 8] = [
    "demo",
    "train",
    "evaluate",
    "transition",
    "compare",
    "render",
    "analyse",
    "export",
];

#[test]
fn help_names_every_command_and_where_to_start() {
    let help = Place::new().stdout("--help");
    for command in COMMANDS {
        assert!(help.contains(command), "{help}");
    }
    assert!(help.contains("Start here"), "{help}");
}

#[test]
fn the_help_of_a_command_describes_each_of_its_options() {
    let place = Place::new();
    // `export` has options by format.
    let formats = ["export mjcf", "export onnx", "export csv", "export npz"];
    let commands = COMMANDS.iter().filter(|command| **command != "export");
    for command in commands.chain(&formats) {
        let help = place.stdout(&format!("{command} --help"));
        let mut lines = help
            .lines()
            .skip_while(|line| *line != "Options:")
            .peekable();
        let mut options = 0;
        while let Some(line) = lines.next() {
            if line.trim_start().starts_with("--") || line.trim_start().starts_with("-o") {
                options += 1;
                let next = lines.peek().copied().unwrap_or("");
                assert!(
                    next.starts_with("          "),
                    "{command}: {line} is not described"
                );
            }
        }
        assert!(options > 0, "{command}: {help}");
    }
    // The contracts that other programs rely on are part of the help.
    assert!(
        place
            .stdout("evaluate --help")
            .contains("\"double_support\"")
    );
    assert!(
        place
            .stdout("transition --help")
            .contains("steps_to_change")
    );
    assert!(
        place
            .stdout("train --help")
            .contains("--resume runs/fast-1")
    );
}

#[test]
fn without_a_command_it_shows_how_to_use_it() {
    let output = Place::new().output("");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("Usage: gaitshift"));
}

#[test]
fn unknown_words_are_refused() {
    let place = Place::new();
    place.refused("walk", &["walk"]);
    place.refused("evaluate --speed 3", &["--speed"]);
    place.refused("evaluate 3", &["3"]);
    place.refused("render", &["RECORDING.csv"]);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let place = Place::new();
    let cases = [
        ("evaluate --omega-v 1e9", "--omega-v", "from -100 to 100"),
        ("evaluate --omega-v 0,nan", "--omega-v", "from -100 to 100"),
        ("evaluate --omega-v 0,,3", "--omega-v", "not a number"),
        ("evaluate --omega-v=", "--omega-v", "not a number"),
        ("evaluate --omega-v fast", "--omega-v", "not a number"),
        (
            "evaluate --duration-s -1",
            "--duration-s",
            "from 0.1 to 3600 s",
        ),
        (
            "evaluate --duration-s=-1",
            "--duration-s",
            "from 0.1 to 3600 s",
        ),
        (
            "evaluate --duration-s 0",
            "--duration-s",
            "from 0.1 to 3600 s",
        ),
        (
            "evaluate --duration-s inf",
            "--duration-s",
            "from 0.1 to 3600 s",
        ),
        (
            "evaluate --settling-s=-5",
            "--settling-s",
            "from 0 to 3600 s",
        ),
        ("evaluate --seed=-1", "--seed", "-1"),
        ("evaluate --seed 1.5", "--seed", "1.5"),
        ("transition --from nan", "--from", "from -100 to 100"),
        ("transition --to 1e300", "--to", "from -100 to 100"),
        ("transition --ramp-s=-0.4", "--ramp-s", "from 0 to 3600 s"),
        ("transition --start-s nan", "--start-s", "from 0 to 3600 s"),
        ("transition --after-s 0", "--after-s", "from 0.1 to 3600 s"),
        ("train --threads 0", "--threads", "1..=256"),
        ("train --steps 0", "--steps", "0"),
        ("train --seed x", "--seed", "x"),
        ("render r.csv --fps nan", "--fps", "finite"),
        ("render r.csv --width -3", "--width", "-3"),
    ];
    for (arguments, option, accepted) in cases {
        place.refused(arguments, &[option, accepted]);
    }
}

#[test]
fn options_that_exclude_each_other_are_refused() {
    let place = Place::new();
    for arguments in [
        "evaluate --omega-v 0 --command-profile p.csv",
        "evaluate --criteria --omega-v 0",
        "transition --from 0 --command-profile p.csv",
        "train fast --resume runs/fast-1",
        "train --seed 2 --resume runs/fast-1",
        // Of these the second was ignored.
        "train --check --view",
        "sweep s.toml --table --jobs 4",
    ] {
        place.refused(arguments, &["cannot be used with"]);
    }
}

// `--friction 0.5` was unexpected, and nothing said what would be taken.
#[test]
fn a_key_given_as_an_option_is_answered_by_how_to_set_it() {
    let place = Place::new();
    place.refused(
        "evaluate --friction 0.5",
        &["--friction", "--set friction=VALUE"],
    );
    place.refused("evaluate --foot-mass-kg 2", &["--set foot_mass_kg=VALUE"]);
    let stderr = place.output("evaluate --walrus").stderr;
    assert!(!String::from_utf8_lossy(&stderr).contains("--set"));
}

// The usage that an error showed was itself refused: `Usage: gaitshift train --resume <DIR> <RECIPE|FILE.toml>`.
#[test]
fn errors_show_no_usage_that_is_none() {
    let place = Place::new();
    for arguments in [
        "train --resume x fast",
        "evaluate --criteria --duration-s 1",
        "evaluate --omega-v a",
        "train --seed 1 --seeds 2-3",
    ] {
        let output = place.output(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(!stderr.contains("Usage"), "{stderr}");
        assert!(stderr.contains("--help"), "{stderr}");
    }
}
