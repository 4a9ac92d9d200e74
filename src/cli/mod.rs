//! The command line: one thin subcommand a file. Exit status 0 good, 1 failed, 2 bad usage.

mod accuracy;
mod export;
mod gpu;
mod load;
mod network;
mod npz;
mod plan;
mod probe;
mod record;
mod replay;
mod scene;
mod serve;
mod tls;
mod watch;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// One spectral ocean, simulated once and streamed to many thin clients.
#[derive(Debug, Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    serve: serve::ServeArguments,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serve a scene; also what happens without a command.
    Serve(serve::ServeArguments),
    /// Watch a server: live figures, a picture, or a report as JSON.
    Watch(crate::client::WatchArguments),
    /// Keep what a server streams in a file.
    Record(crate::client::RecordArguments),
    /// Serve a recording as if it were live.
    Replay(replay::ReplayArguments),
    /// Test how many clients a server holds: throughput, ages, gaps, and what it costs.
    Load(Box<crate::load::LoadArguments>),
    /// Send raw messages to many connections; `load --calibrate` starts it.
    #[command(hide = true, name = crate::load::CALIBRATOR)]
    Calibrator,
    /// Write the fields of one tick to an .npz file.
    Export(export::ExportArguments),
    /// Print what a demand takes, pass by pass, and what each effect costs on this machine.
    Plan(plan::PlanArguments),
    /// Measure what accuracy costs in time on this machine: errors beside the exact sea, times, bytes, memory.
    Accuracy(accuracy::AccuracyArguments),
    /// Print the water at one point of the world as JSON.
    Probe(probe::ProbeArguments),
}

/// Runs the program.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match arguments.command {
        None => serve::run(arguments.serve),
        Some(Command::Serve(arguments)) => serve::run(arguments),
        Some(Command::Watch(arguments)) => watch::run(&arguments),
        Some(Command::Record(arguments)) => record::run(&arguments),
        Some(Command::Replay(arguments)) => replay::run(arguments),
        Some(Command::Load(arguments)) => load::run(&arguments),
        Some(Command::Calibrator) => load::calibrator(),
        Some(Command::Export(arguments)) => export::run(&arguments),
        Some(Command::Plan(arguments)) => plan::run(&arguments),
        Some(Command::Accuracy(arguments)) => accuracy::run(&arguments),
        Some(Command::Probe(arguments)) => probe::run(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("swellcast: {error:#}");
            ExitCode::FAILURE
        }
    }
}
