//! The program: window by default, otherwise one of the commands of the command line.
//!
//! Answers go to stdout, what is wrong to stderr; exit code 0 is done, 2 is not.

use burin::document::answers::Answer;
use burin::document::{
    Document, DocumentError, KeepError, OpenAs, Origin, ProjectCommand, ReadDocument, USUAL_COMPONENT, Wanted, at_home,
};
use burin::interact::readout;
use burin::script;
use burin::script::{json_line, plain};
use clap::{Parser, Subcommand};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
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
        /// The volume of a project that names it, where it is not at the place that the project knows.
        #[arg(long, requires = "project")]
        source: Option<PathBuf>,
        /// Goes on after a command that failed; the exit code is 2 all the same.
        #[arg(long)]
        keep_going: bool,
    },
    /// Draws a project or a volume file to a picture. Nothing is changed on disk but the picture.
    Render {
        /// A project folder or a volume file.
        path: PathBuf,
        /// The volume of a project that names it, where it is not at the place that the project knows.
        #[arg(long)]
        source: Option<PathBuf>,
        /// PNG or EXR, by extension.
        #[arg(short, long)]
        output: PathBuf,
        /// Width and height in pixels, e.g. 800x600; the view's own if left out.
        #[arg(long, value_parser = size)]
        size: Option<[u32; 2]>,
        /// From where: x,y,z, the direction from the volume to the eye in RAS; or a camera as JSON, as scripts have it.
        #[arg(long, allow_hyphen_values = true)]
        camera: Option<String>,
        /// Degree of explosion, settled before the picture is drawn.
        #[arg(long, allow_negative_numbers = true, value_parser = finite)]
        degree: Option<f64>,
        /// Which view.
        #[arg(long, default_value = "3d", value_parser = ["3d", "axial", "coronal", "sagittal"])]
        view: String,
        /// Which frame of a volume file, counted from 0.
        #[arg(long)]
        frame: Option<u32>,
        /// Which component of a volume file, counted from 0.
        #[arg(long)]
        component: Option<u32>,
        /// Drawn so many times larger either way and averaged, 1 to 8.
        #[arg(long, default_value_t = 1)]
        supersample: u32,
        /// A PNG that is transparent instead of the look's background; an EXR always is.
        #[arg(long, conflicts_with = "background")]
        transparent: bool,
        /// What lies behind the picture instead of the look's background: #rrggbb, or r,g,b of 0 to 1.
        #[arg(long, value_parser = colour)]
        background: Option<[f32; 3]>,
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
            warn(&error);
            ExitCode::from(2)
        }
    }
}

fn perform(arguments: Arguments) -> Result<(), String> {
    if let None | Some(Command::Run { .. }) = arguments.command {
        burin::document::remove_dead_history(&std::env::temp_dir());
    }
    match arguments.command {
        None => burin::ui::run(burin::ui::Options { open: arguments.path.map(at_home) }),
        Some(Command::Run { script, project, source, keep_going }) => run(&script, project, source, keep_going),
        Some(Command::Info { file, json }) => info(&at_home(file), json),
        Some(Command::Render {
            path,
            source,
            output,
            size,
            camera,
            degree,
            view,
            frame,
            component,
            supersample,
            transparent,
            background,
        }) => {
            let output = output.to_str().ok_or("--output: a name that is not UTF-8 found, UTF-8 expected")?;
            let image = json!({
                "path": output,
                "size": size,
                "view": view,
                "supersample": supersample,
                "transparent": transparent,
                "background": background,
            });
            render(&at_home(path), source.map(at_home), [frame, component], camera, degree, &image)
        }
        Some(Command::Schema) => {
            let schema = serde_json::to_string_pretty(&script::schema()).map_err(|e| e.to_string())?;
            say(&schema)
        }
    }
}

fn run(path: &Path, project: Option<PathBuf>, source: Option<PathBuf>, keep_going: bool) -> Result<(), String> {
    let input: Box<dyn BufRead> = if path == Path::new("-") {
        Box::new(std::io::stdin().lock())
    } else {
        let failed = |e| format!("{}: cannot open the script: {e}; `-` reads one from a pipe", path.display());
        Box::new(BufReader::new(burin::io::open_regular(path).map_err(failed)?))
    };
    let mut document = Document::new();
    if let Some(dir) = project.map(at_home) {
        let open = ProjectCommand::Open { path: dir.clone(), source, generation: None };
        match document.apply(burin::document::Command::Project(open)) {
            Ok(answer) => tell(&dir, &answer),
            // A file of that name would be found out only by a save.
            Err(DocumentError::Keep(KeepError::NotAProject { .. })) if dir.exists() && !dir.is_dir() => {
                let what = "a file found, a project's folder or a name for one expected; a script opens a volume by volume.open";
                return Err(format!("--project {}: {what}", dir.display()));
            }
            Err(DocumentError::Keep(KeepError::NotAProject { .. })) => document.save_to(dir),
            Err(error) => return Err(said(error)),
        }
    }
    let outcome = script::run(&mut document, input, std::io::stdout().lock(), keep_going)
        .map_err(|e| format!("{}: {e}", path.display()))?;
    source_is_right(&document);
    // The script has said what to save; a process that is killed instead leaves its journal to be found. What a crash left
    // before is not the script's to throw away.
    document.leave_as_found().map_err(said)?;
    match outcome.failed {
        0 => Ok(()),
        n => Err(format!("{}: {n} of {} commands failed", path.display(), n + outcome.done)),
    }
}

/// Says the same to a document as a script would.
fn render(
    path: &Path,
    source: Option<PathBuf>,
    [frame, component]: [Option<u32>; 2],
    camera: Option<String>,
    degree: Option<f64>,
    image: &Value,
) -> Result<(), String> {
    if let (Some(_), Some(view)) = (&camera, image["view"].as_str().filter(|view| *view != "3d")) {
        return Err(format!("--camera: one for the {view} view found, none for a slice expected"));
    }
    let mut document = Document::new();
    let opened = if path.is_dir() {
        for (name, given) in [("frame", frame), ("component", component)] {
            if let Some(found) = given {
                return Err(format!("--{name}: {found} found for a project, which has its own; none expected"));
            }
        }
        ReadDocument::project_to_read(path, Wanted { source: source.as_deref(), generation: None }, &|_| true)
    } else {
        let (component, frame) = (component.unwrap_or(USUAL_COMPONENT), frame.unwrap_or(0));
        ReadDocument::volume(Origin { path: path.into(), component, frame }, None, OpenAs::Image, None, &|_| true)
    };
    tell(path, &document.take(opened.map_err(said)?));
    let mut lines = Vec::new();
    if let Some(text) = camera {
        lines.push(match serde_json::from_str::<Value>(&text) {
            Ok(camera) if camera.is_object() => json!({ "view": { "camera": { "camera": camera } } }),
            _ => {
                let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
                let from = numbers.ok().filter(|n| n.len() == 3);
                let from = from.ok_or(format!("--camera: {text} found, x,y,z or a camera as JSON expected"))?;
                json!({ "view": { "frame": { "from": from } } })
            }
        });
    }
    if let Some(value) = degree {
        lines.push(json!({ "explosion": { "degree": { "value": value } } }));
        lines.push(json!({ "explosion": { "settle": {} } }));
    }
    lines.push(json!({ "render": { "image": image } }));
    for line in lines {
        let answer = script::perform(&mut document, &line.to_string())?;
        if line.get("render").is_some() {
            say(&json_line(&answer))?;
        }
    }
    source_is_right(&document);
    Ok(())
}

/// Says what is to be known of a document that was opened: what is wrong with it, what came back, what is lost.
fn tell(path: &Path, answer: &Answer) {
    let recovered = answer.recovered().and_then(readout::recovered);
    for told in answer.warnings().map(str::to_owned).chain(recovered) {
        warn(&format!("{}: {told}", path.display()));
    }
}

/// Says so if the file that a project names is not the one that was painted on.
fn source_is_right(document: &Document) {
    if let Some(trouble) = document.source_trouble(true) {
        warn(&trouble);
    }
}

/// One line on stderr.
fn warn(text: &str) {
    eprintln!("burin: {}", plain(text));
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|n: &f64| n.is_finite());
    number.ok_or(format!("{text} found, a number expected"))
}

/// `#rrggbb`, or three numbers of 0 to 1.
fn colour(text: &str) -> Result<[f32; 3], String> {
    let bytes = text.strip_prefix('#').filter(|hex| hex.len() == 6).and_then(|hex| u32::from_str_radix(hex, 16).ok());
    let numbers: Option<Vec<f32>> = match bytes {
        Some(bytes) => Some([16, 8, 0].map(|shift| (bytes >> shift & 255) as f32 / 255.0).to_vec()),
        None => text.split(',').map(|n| n.trim().parse().ok()).collect(),
    };
    let colour = numbers.and_then(|n| <[f32; 3]>::try_from(n).ok());
    let colour = colour.filter(|c| c.iter().all(|c| (0.0..=1.0).contains(c)));
    colour.ok_or(format!("{text} found, #rrggbb or r,g,b of 0 to 1 expected"))
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parts: Vec<_> = text.split(['x', 'X']).map(str::parse).collect();
    match parts[..] {
        [Ok(width), Ok(height)] => Ok([width, height]),
        _ => Err(format!("{text} found, WIDTHxHEIGHT expected, e.g. 800x600")),
    }
}

fn info(file: &Path, json: bool) -> Result<(), String> {
    let info = burin::io::info(file, &|_| true).map_err(|e| e.to_string())?;
    if json {
        return say(&json_line(&serde_json::to_value(&info).map_err(|e| e.to_string())?));
    }
    let value = serde_json::to_value(&info).map_err(|e| e.to_string())?;
    for (name, value) in value.as_object().into_iter().flatten() {
        say(&plain(&format!("{name}: {value}")))?;
    }
    Ok(())
}

fn said(error: DocumentError) -> String {
    error.to_string()
}

/// One line on stdout. A reader that has seen enough and closed the pipe is no error.
fn say(line: &str) -> Result<(), String> {
    match writeln!(std::io::stdout(), "{line}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(format!("stdout: {error}")),
        _ => Ok(()),
    }
}
