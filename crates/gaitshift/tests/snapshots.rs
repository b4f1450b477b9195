//! Contract: the help of every command, typical errors, and what the shipped controllers do, are word for word what `snapshots/*.trycmd` shows, with the
//! exit codes there. After a change that is meant, accept it and read the difference:
//!
//!     TRYCMD=overwrite cargo test -p gaitshift snapshots::

use crate::common::Place;

#[test]
fn help_and_errors_are_as_recorded() {
    trycmd::TestCases::new()
        .env("COLUMNS", "100")
        .case("tests/snapshots/*.trycmd");
}

/// A new command was easily added without its help being recorded.
#[test]
fn the_help_of_every_command_is_recorded() {
    let recorded = include_str!("snapshots/help.trycmd");
    let mut commands = vec![String::new()];
    while let Some(command) = commands.pop() {
        let line = format!("$ gaitshift{command} --help\n");
        assert!(
            recorded.contains(&line),
            "snapshots/help.trycmd lacks `{}`",
            line.trim_end()
        );
        let listed = Place::new().commands(&command);
        commands.extend(listed.iter().map(|name| format!("{command} {name}")));
    }
}
