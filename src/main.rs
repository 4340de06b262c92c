//! The program: window by default, otherwise one of the commands of the command line.
//!
//! Answers go to stdout, what is wrong to stderr; exit code 0 is done, 2 is not.

use burin::document::{Document, DocumentError, ProjectCommand};
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
        /// A project to start with; if the folder is none yet, `project.save` without a path makes it one.
        #[arg(long)]
        project: Option<PathBuf>,
        /// Goes on after a command that failed; the exit code is 2 all the same.
        #[arg(long)]
        keep_going: bool,
    },
    /// Tells what is in a volume file.
    Info {
        /// The file.
        file: PathBuf,
        /// As one line of JSON.
        #[arg(long)]
        json: bool,
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
        Some(Command::Run { script, project, keep_going }) => run(&script, project, keep_going),
        Some(Command::Info { file, json }) => info(&file, json),
        Some(Command::Schema) => {
            let schema = serde_json::to_string_pretty(&script::schema()).map_err(|e| e.to_string())?;
            println!("{schema}");
            Ok(())
        }
    }
}

fn run(path: &Path, project: Option<PathBuf>, keep_going: bool) -> Result<(), String> {
    let input: Box<dyn BufRead> = if path == Path::new("-") {
        Box::new(std::io::stdin().lock())
    } else {
        Box::new(BufReader::new(std::fs::File::open(path).map_err(|e| format!("{}: {e}", path.display()))?))
    };
    let mut document = Document::new();
    if let Some(dir) = project {
        if dir.join("project.json").exists() {
            document.apply(burin::document::Command::Project(ProjectCommand::Open { path: dir })).map_err(said)?;
        } else {
            document.save_to(dir);
        }
    }
    let outcome = script::run(&mut document, input, std::io::stdout().lock(), keep_going)
        .map_err(|e| format!("{}: {e}", path.display()))?;
    // The script has said what to save; a process that is killed instead leaves its journal to be found.
    document.discard_unsaved().map_err(said)?;
    match outcome.failed {
        0 => Ok(()),
        n => Err(format!("{}: {n} of {} commands failed", path.display(), n + outcome.done)),
    }
}

fn info(file: &Path, json: bool) -> Result<(), String> {
    let info = burin::io::info(file, &|_| true).map_err(|e| e.to_string())?;
    if json {
        println!("{}", serde_json::to_string(&info).map_err(|e| e.to_string())?);
        return Ok(());
    }
    let value = serde_json::to_value(&info).map_err(|e| e.to_string())?;
    for (name, value) in value.as_object().into_iter().flatten() {
        println!("{name}: {value}");
    }
    Ok(())
}

fn said(error: DocumentError) -> String {
    error.to_string()
}
