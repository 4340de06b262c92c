//! The program: window by default, otherwise one of the commands of the command line.
//!
//! Answers go to stdout, what is wrong to stderr; exit code 0 is done, 2 is not.

use burin::document::Document;
use burin::script;
use clap::{Parser, Subcommand};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Paint, cut and explode volumes.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// A project folder or a volume file to open in the window.
    path: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Does a script's commands, one JSON object a line; answers with one JSON object each. Saves nothing unless told by the
    /// script.
    Run {
        /// The script; `-` is stdin.
        script: PathBuf,
        /// Goes on after a command that failed; the exit code is 2 all the same.
        #[arg(long)]
        keep_going: bool,
    },
    /// Prints the JSON Schema of a script's line.
    Schema,
}

fn main() -> ExitCode {
    tracing_subscriber::fmt()
        .with_env_filter(tracing_subscriber::EnvFilter::from_default_env())
        .with_writer(std::io::stderr)
        .init();
    match perform(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("burin: {error}");
            ExitCode::from(2)
        }
    }
}

fn perform(arguments: Arguments) -> Result<(), String> {
    match arguments.command {
        None => Err("this build has no window; `burin run SCRIPT` does the same commands".into()),
        Some(Command::Run { script, keep_going }) => run(&script, keep_going),
        Some(Command::Schema) => {
            let schema = serde_json::to_string_pretty(&script::schema()).map_err(|e| e.to_string())?;
            println!("{schema}");
            Ok(())
        }
    }
}

fn run(path: &Path, keep_going: bool) -> Result<(), String> {
    let input: Box<dyn BufRead> = if path == Path::new("-") {
        Box::new(std::io::stdin().lock())
    } else {
        Box::new(BufReader::new(std::fs::File::open(path).map_err(|e| format!("{}: {e}", path.display()))?))
    };
    let mut document = Document::new();
    let outcome = script::run(&mut document, input, std::io::stdout().lock(), keep_going)
        .map_err(|e| format!("{}: {e}", path.display()))?;
    match outcome.failed {
        0 => Ok(()),
        n => Err(format!("{}: {n} of {} commands failed", path.display(), n + outcome.done)),
    }
}
