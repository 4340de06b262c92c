//! The program in a real window with a real pointer: a volume is opened, painted on and saved.

use crate::common::gpu::missing;
use burin::document::{Command, Document, ProjectCommand, Question};
use burin::volume::FieldKind;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command as Process, Stdio};
use std::time::{Duration, Instant};

/// How long a loaded machine may take for one thing. An idle one needs a tenth.
const PATIENCE: Duration = Duration::from_secs(60);

/// Ends what it started, however the test ends.
struct Running(Child);

impl Running {
    /// Starts a program that ends with this test, and with this process, also where that is killed.
    fn start(program: &mut Process) -> std::io::Result<Self> {
        #[cfg(target_os = "linux")]
        {
            use rustix::process::{Signal, set_parent_process_death_signal};
            use std::os::unix::process::CommandExt;
            // SAFETY: between fork and exec only a system call is made.
            unsafe { program.pre_exec(|| Ok(set_parent_process_death_signal(Some(Signal::KILL))?)) };
        }
        program.spawn().map(Self)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

struct Desk {
    display: String,
    _server: Running,
}

impl Desk {
    /// A screen of its own; `None` where the tools are missing and that is known.
    fn new() -> Option<Self> {
        // Without -noreset the server starts anew whenever its last client leaves, as xdotool does at every look, and turns away
        // a program that connects at that moment.
        let mut server = Process::new("Xvfb");
        server
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let Ok(mut server) = Running::start(&mut server) else {
            missing("Xvfb does not start", "Xvfb (Debian: xvfb)");
            return None;
        };
        let mut number = String::new();
        BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let desk = Self { display: format!(":{}", number.trim()), _server: server };
        if number.trim().is_empty() {
            missing("Xvfb gave no display", "Xvfb with its fonts (Debian: xvfb)");
            return None;
        }
        if desk.xdotool(&["version"]).is_none() {
            missing("xdotool does not start", "xdotool (Debian: xdotool)");
            return None;
        }
        Some(desk)
    }

    fn xdotool(&self, arguments: &[&str]) -> Option<String> {
        let done = Process::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.display)
            .stderr(Stdio::null())
            .output()
            .ok()?;
        Some(String::from_utf8_lossy(&done.stdout).trim().to_owned())
    }

    /// Events of one frame are one event to the program: a pause after each.
    fn hand(&self, arguments: &[&str]) {
        self.xdotool(arguments).unwrap();
        std::thread::sleep(Duration::from_millis(60));
    }

    fn wait_for_title(&self, window: &str, wanted: impl Fn(&str) -> bool) -> String {
        wait_for(|| {
            let title = self.xdotool(&["getwindowname", window]).unwrap();
            if wanted(&title) { Ok(title) } else { Err(format!("the title is {title:?}")) }
        })
    }
}

fn wait_for<T>(mut look: impl FnMut() -> Result<T, String>) -> T {
    let start = Instant::now();
    loop {
        match look() {
            Ok(found) => return found,
            Err(said) => assert!(start.elapsed() < PATIENCE, "waited in vain: {said}"),
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// 32³ voxels of 2 mm with a ball of 200 in the middle.
fn write_ball(path: &Path) {
    let mut bytes = b"NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 32 32 32\n\
        space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\n"
        .to_vec();
    let square = |i: i32| (2 * i - 31).pow(2);
    bytes.extend(
        (0..32 * 32 * 32).map(|n| if square(n % 32) + square(n / 32 % 32) + square(n / 1024) < 600 { 200 } else { 10 }),
    );
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_stroke_by_hand_is_in_the_saved_project() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let Some(desk) = Desk::new() else { return };
    let dir = tempfile::tempdir().unwrap();
    write_ball(&dir.path().join("ball.nrrd"));
    let said = dir.path().join("said");
    let mut program = Process::new(crate::common::program());
    program
        .arg(dir.path().join("ball.nrrd"))
        .env("DISPLAY", &desk.display)
        .env("BURIN_STATE_DIR", dir.path().join("state"))
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("DBUS_SESSION_BUS_ADDRESS")
        .stderr(std::fs::File::create(&said).unwrap());
    let mut program = Running::start(&mut program).unwrap();
    let window = wait_for(|| {
        if let Some(status) = program.0.try_wait().unwrap() {
            panic!("the program ended, {status}: {}", std::fs::read_to_string(&said).unwrap());
        }
        let found = desk.xdotool(&["search", "--onlyvisible", "--name", "Burin"]).unwrap();
        found.lines().last().map(str::to_owned).ok_or_else(|| "no window".to_owned())
    });
    desk.wait_for_title(&window, |t| t.starts_with("ball.nrrd –"));
    desk.hand(&["windowfocus", &window]);
    desk.hand(&["mousemove", "800", "230"]);
    desk.hand(&["key", "b"]);
    desk.hand(&["mousedown", "1"]);
    for x in ["804", "810", "816", "822", "828"] {
        desk.hand(&["mousemove", x, "236"]);
    }
    desk.hand(&["mouseup", "1"]);
    desk.wait_for_title(&window, |t| t.starts_with("ball.nrrd* –"));
    // Where no portal answers a path is typed; the one offered is beside the volume. A slow machine shows it late, so Return is
    // pressed until it was heard.
    desk.hand(&["key", "ctrl+s"]);
    wait_for(|| {
        std::thread::sleep(Duration::from_millis(400));
        desk.hand(&["key", "Return"]);
        let title = desk.xdotool(&["getwindowname", &window]).unwrap();
        if title.starts_with("ball.burin –") { Ok(()) } else { Err(format!("the title is {title:?}")) }
    });
    drop(program);

    let mut document = Document::new();
    document
        .apply(Command::Project(ProjectCommand::Open {
            path: dir.path().join("ball.burin"),
            source: None,
            generation: None,
        }))
        .unwrap();
    let painted = document
        .apply(Command::Ask(Question::Field { field: FieldKind::Selection, volume: None }))
        .unwrap()
        .to_json()
        .unwrap();
    let count = painted["nonzero"].as_u64().unwrap();
    // A ball of 5 mm drawn along 24 pixels, 31 if the press counted as it fell, in voxels of 8 mm³; a tenth for their corners.
    let scene = document.apply(Command::Ask(Question::Scene {})).unwrap().to_json().unwrap();
    let slice = &scene["scene"]["views"]["slices"][0];
    let mm_per_px = slice["height_mm"].as_f64().unwrap() / slice["size"][1].as_f64().unwrap();
    let voxels = |px: f64| (4.0 / 3.0 * 125.0 + 25.0 * px * mm_per_px) * std::f64::consts::PI / 8.0;
    assert!((voxels(24.0) * 0.9..voxels(31.0) * 1.1).contains(&(count as f64)), "{painted}: {mm_per_px} mm a pixel");
}
