//! `gaitshift manual`: manual pages, from the same source as `--help`.

use crate::arguments::{Arguments, ManualArguments};
use crate::failure::Failure;
use crate::output;
use clap::CommandFactory;
use clap_mangen::Man;
use std::io::Write;
use std::path::Path;

/// Runs the command.
pub fn run(arguments: &ManualArguments) -> Result<(), Failure> {
    let mut program = Arguments::command();
    program.build();
    let Some(folder) = &arguments.out else {
        return Ok(std::io::stdout().write_all(&page(&program)?)?);
    };
    output::create_folder(folder)?;
    let mut files = vec![write(&program, folder, "gaitshift.1")?];
    for command in program.get_subcommands().filter(|c| c.get_name() != "help") {
        let name = format!("gaitshift-{}.1", command.get_name());
        files.push(write(command, folder, &name)?);
    }
    output::written(&files)
}

fn page(command: &clap::Command) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    Man::new(command.clone())
        .render(&mut page)
        .map_err(Failure::run)?;
    Ok(page)
}

fn write(
    command: &clap::Command,
    folder: &Path,
    name: &str,
) -> Result<std::path::PathBuf, Failure> {
    let path = folder.join(name);
    std::fs::write(&path, page(command)?).map_err(|e| Failure::write(&path, &e))?;
    Ok(path)
}
