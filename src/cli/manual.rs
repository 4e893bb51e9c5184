//! Shell completions and manual pages.

use super::args::{Arguments, CompletionsArguments, ManArguments};
use super::failure::Failure;
use super::output;
use clap::CommandFactory;
use latchgate_recording::error::Error;

/// Prints the completions for a shell.
pub(super) fn completions(arguments: &CompletionsArguments) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(
        arguments.shell,
        &mut Arguments::command(),
        "latchgate",
        &mut script,
    );
    output::document(&String::from_utf8_lossy(&script)).map_err(Failure::Data)?;
    Ok(0)
}

/// Prints the manual page of latchgate or of one command, in roff.
pub(super) fn man(arguments: &ManArguments) -> Result<u8, Failure> {
    let mut root = Arguments::command();
    root.build();
    let mut page = root;
    let mut name = String::from("latchgate");
    for word in &arguments.command {
        let Some(subcommand) = page.find_subcommand(word) else {
            let names: Vec<&str> = page
                .get_subcommands()
                .map(clap::Command::get_name)
                .collect();
            return Err(Failure::Usage(Error::unknown(
                "command",
                word.clone(),
                &names,
            )));
        };
        name = format!("{name}-{word}");
        page = subcommand.clone().name(name.clone());
    }
    let mut roff = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut roff)
        .map_err(|error| Failure::Data(Error::io("write the manual page", &error)))?;
    output::document(&String::from_utf8_lossy(&roff)).map_err(Failure::Data)?;
    Ok(0)
}
