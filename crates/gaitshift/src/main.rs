//! The program `gaitshift`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(gaitshift::run(std::env::args_os()))
}
