//! `gaitshift manual`: manual pages, from the same source as `--help`.

use crate::arguments::{Arguments, ManualArguments};
use crate::failure::Failure;
use crate::output;
use clap::CommandFactory;
use clap_mangen::Man;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Runs the command.
pub fn run(arguments: &ManualArguments) -> Result<(), Failure> {
    let mut program = Arguments::command();
    program.build();
    let Some(folder) = &arguments.out else {
        return Ok(std::io::stdout().write_all(&page(&program)?)?);
    };
    output::create_folder(folder)?;
    let mut files = vec![write(&program, folder, "gaitshift.1")?];
    write_all(&program, "gaitshift", folder, &mut files)?;
    output::written(&files)
}

/// The pages of a command's own commands, which it refers to.
fn write_all(
    of: &clap::Command,
    within: &str,
    folder: &Path,
    files: &mut Vec<PathBuf>,
) -> Result<(), Failure> {
    for command in of.get_subcommands().filter(|c| c.get_name() != "help") {
        let name = format!("{within}-{}", command.get_name());
        files.push(write(command, folder, &format!("{name}.1"))?);
        write_all(command, &name, folder, files)?;
    }
    Ok(())
}

fn page(command: &clap::Command) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    Man::new(command.clone())
        .render(&mut page)
        .map_err(Failure::run)?;
    Ok(page)
}

fn write(command: &clap::Command, folder: &Path, name: &str) -> Result<PathBuf, Failure> {
    let path = folder.join(name);
    output::file(&path, &page(command)?)?;
    Ok(path)
}
