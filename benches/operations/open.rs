//! Peak memory of opening and drawing a large volume, pool included: measured in a process of its own.

use super::head::Failure;
use super::measure::Report;
use burin::document::{Command, Document};
use std::io::Write;

/// First argument of the child process.
pub const CHILD: &str = "--open-and-draw";

pub fn memory(report: &mut Report) -> Result<(), Failure> {
    let dir = tempfile::tempdir()?;
    let n = 512_u32;
    let bytes = u64::from(n).pow(3) * 2;
    for encoding in ["raw", "gzip"] {
        let path = dir.path().join(format!("cube_{encoding}.nrrd"));
        write_nrrd(&path, n, encoding)?;
        let output = std::process::Command::new(std::env::current_exe()?).arg(CHILD).arg(&path).output()?;
        let text = String::from_utf8_lossy(&output.stdout);
        let peak: u64 = text
            .trim()
            .parse()
            .map_err(|_| format!("the child said: {text}{}", String::from_utf8_lossy(&output.stderr)))?;
        let allowed = bytes * 3 + 400_000_000;
        report.note(&format!(
            "open and draw 512³ u16 ({encoding}): peak {:.0} MB, {:.2} of three times its bytes + 400 MB",
            peak as f64 / 1e6,
            peak as f64 / allowed as f64
        ));
    }
    Ok(())
}

/// Opens, draws once, prints its own peak memory in bytes.
pub fn child(arguments: &[String]) {
    let run = || -> Result<u64, Failure> {
        let path = arguments.first().ok_or("a file is expected")?;
        let mut document = Document::new();
        let out = tempfile::tempdir()?;
        for line in [
            serde_json::json!({"volume": {"open": {"path": path}}}),
            serde_json::json!({"render": {"image": {"path": out.path().join("a.png"), "size": [512, 512]}}}),
        ] {
            document.apply(serde_json::from_value::<Command>(line)?)?;
        }
        let status = std::fs::read_to_string("/proc/self/status")?;
        let peak = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).ok_or("no VmHWM")?;
        Ok(peak.trim().trim_end_matches("kB").trim().parse::<u64>()? * 1024)
    };
    match run() {
        Ok(peak) => println!("{peak}"),
        Err(error) => {
            eprintln!("{error}");
            std::process::exit(1);
        }
    }
}

/// Smooth blobs with a little noise, so that neither bricks nor bytes are uniform.
fn write_nrrd(path: &std::path::Path, n: u32, encoding: &str) -> Result<(), Failure> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    write!(
        file,
        "NRRD0004\ntype: uint16\ndimension: 3\nspace: left-posterior-superior\nsizes: {n} {n} {n}\nspace directions: \
         (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nendian: little\nencoding: {encoding}\n\n"
    )?;
    let mut out: Box<dyn Write> = match encoding {
        "gzip" => Box::new(flate2::write::GzEncoder::new(file, flate2::Compression::fast())),
        _ => Box::new(file),
    };
    let mut noise = 1_u32;
    for z in 0..n {
        let mut slice = Vec::with_capacity((n * n * 2) as usize);
        for y in 0..n {
            for x in 0..n {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let d = [x, y, z].map(|v| f64::from(v) / f64::from(n) - 0.5);
                let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                let value = (1.0 - 2.0 * r).max(0.0) * 30_000.0 + f64::from(noise >> 24);
                slice.extend_from_slice(&(value as u16).to_le_bytes());
            }
        }
        out.write_all(&slice)?;
    }
    out.flush()?;
    Ok(())
}
