//! The `hysteron` command: from measured records to an identified, validated, reported model.
//!
//! One file a subcommand; the numbers are the library's. Results go to standard output, messages and progress
//! to standard error. Exit code 0: done; 1: could not (bad data, no fit); 2: wrong usage.

use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

mod adapt;
mod advice;
mod app;
mod article;
mod axes;
mod choices;
mod columns;
mod compare;
mod completions;
mod console;
mod correction;
mod cut;
mod design;
mod excite;
mod export;
mod failure;
mod frequency_response;
mod identify;
mod inspect;
mod interrupt;
mod invert;
mod kept;
mod maker;
mod model;
mod numbers;
mod optimizers;
mod output;
mod outputs;
mod prepare;
mod progress;
mod rate;
mod realise;
mod recalibrate;
mod registry;
mod remarks;
mod result_flags;
mod rig;
mod schema;
mod scores;
mod simulate;
mod start;
mod track;
mod validate;

use failure::Failure;

/// Reuses freed memory in the next search; the system allocator would return it and have it zeroed again.
#[global_allocator]
static GLOBAL: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Models of piezo actuators from measured records: hysteresis followed by fractional-order dynamics.
#[derive(Parser)]
#[command(name = "hysteron", version, propagate_version = true, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 could not (bad data, no fit), 2 wrong usage, 130 or 143 interrupted \
    (SIGINT, SIGTERM).\n\
    Results go to standard output, messages and progress to standard error."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Identify(Box<identify::Identify>),
    Compare(compare::Compare),
    Inspect(inspect::Inspect),
    Prepare(Box<prepare::PrepareCommand>),
    Recalibrate(recalibrate::Recalibrate),
    Adapt(Box<adapt::Adapt>),
    Validate(validate::Validate),
    FrequencyResponse(Box<frequency_response::FrequencyResponseCommand>),
    Simulate(simulate::Simulate),
    Invert(invert::Invert),
    Track(Box<track::Track>),
    Realise(realise::Realise),
    Export(export::Export),
    Excite(excite::Excite),
    Design(Box<design::DesignCommand>),
    Rig(rig::Rig),
    Optimizers(optimizers::Optimizers),
    Article(article::Article),
    Registry(registry::RegistryCommand),
    App(app::App),
    Completions(completions::Completions),
    Schema(schema::Schema),
}

fn run(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Identify(c) => c.run(),
        Command::Compare(c) => c.run(),
        Command::Inspect(c) => c.run(),
        Command::Prepare(c) => c.run(),
        Command::Recalibrate(c) => c.run(),
        Command::Adapt(c) => c.run(),
        Command::Validate(c) => c.run(),
        Command::FrequencyResponse(c) => c.run(),
        Command::Simulate(c) => c.run(),
        Command::Invert(c) => c.run(),
        Command::Track(c) => c.run(),
        Command::Realise(c) => c.run(),
        Command::Export(c) => c.run(),
        Command::Excite(c) => c.run(),
        Command::Design(c) => c.run(),
        Command::Rig(c) => c.run(),
        Command::Optimizers(c) => c.run(),
        Command::Article(c) => c.run(),
        Command::Registry(c) => c.run(),
        Command::App(c) => c.run(),
        Command::Completions(c) => c.run(),
        Command::Schema(c) => c.run(),
    }
}

fn main() -> ExitCode {
    let matches = Cli::command().try_get_matches().unwrap_or_else(|e| answer(&e));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    match output::check_distinct(&matches).and_then(|()| run(&cli.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            console::message(&failure.to_string());
            failure.exit_code()
        }
    }
}

/// Prints help, the version, or what is wrong with the command line, and ends.
fn answer(answer: &clap::Error) -> ! {
    let printed = answer.print().and_then(|()| std::io::stdout().flush());
    let is_lost = printed.is_err_and(|e| e.kind() != ErrorKind::BrokenPipe);
    std::process::exit(if is_lost { 1.max(answer.exit_code()) } else { answer.exit_code() })
}
