//! Shell completions and manual pages.

use super::args::{Arguments, CompletionsArguments, ManArguments};
use super::failure::Failure;
use super::output;
use clap::CommandFactory;
use latchgate_recording::error::Error;

/// Prints the completions for a shell.
pub(super) fn completions(own: &CompletionsArguments) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(
        own.shell,
        &mut Arguments::command(),
        "latchgate",
        &mut script,
    );
    output::document(&String::from_utf8_lossy(&script)).map_err(Failure::Data)?;
    Ok(0)
}

/// Prints the manual page of latchgate or of one command, in roff.
pub(super) fn man(own: &ManArguments) -> Result<u8, Failure> {
    let mut root = Arguments::command();
    root.build();
    let mut page = root;
    let mut name = String::from("latchgate");
    for word in &own.command {
        let Some(found) = page.find_subcommand(word) else {
            let known: Vec<&str> = page
                .get_subcommands()
                .map(clap::Command::get_name)
                .collect();
            return Err(Failure::Usage(Error::unknown(
                "command",
                word.clone(),
                &known,
            )));
        };
        name = format!("{name}-{word}");
        page = found.clone().name(name.clone());
    }
    let mut roff = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut roff)
        .map_err(|error| Failure::Data(Error::io("write the manual page", &error)))?;
    output::document(&String::from_utf8_lossy(&roff)).map_err(Failure::Data)?;
    Ok(0)
}
