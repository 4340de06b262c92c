//! Connected components of 256³ voxels (noise, smoothed noise, the head above its background), and the commands and surfaces that
//! rest on them.
//!
//! With `BURIN_PEERS` the masks are written there too, a byte a voxel, so that another program can be given the same.

use super::cube::{apply, over};
use super::head::{Failure, head_values};
use super::measure::{Report, Time, measure};
use burin::segment::{BrickMask, Components, Connectivity};
use burin::volume::{BRICK, BrickIndex, SourceError};
use rand::{Rng, SeedableRng};
use serde_json::json;

const N: usize = 256;

pub fn components(report: &mut Report) -> Result<(), Failure> {
    let head = head_values([N as u32; 3])?;
    let noise = noise();
    let masks: [(&str, Vec<u8>); 3] = [
        ("noise", noise.iter().map(|v| u8::from(*v < 0.5)).collect()),
        ("smoothed noise", smoothed(noise).iter().map(|v| u8::from(*v < 0.5)).collect()),
        ("head", head.iter().map(|v| u8::from(*v >= 40)).collect()),
    ];
    for (name, mask) in &masks {
        if let Some(folder) = std::env::var_os("BURIN_PEERS") {
            std::fs::write(std::path::Path::new(&folder).join(format!("{}.u8", name.replace(' ', "_"))), mask)?;
        }
        let mut found = 0;
        let time = measure(1, 7, |_| -> Result<(), Failure> {
            found =
                Components::new([N as u32; 3], Connectivity::Six, |index| Ok::<_, SourceError>(brick(mask, index)))?
                    .len();
            Ok(())
        })?;
        let keys = [("kind", json!("components")), ("mask", json!(name)), ("components", json!(found))];
        report.beside(&format!("{found} components of {name}, 256³"), time, "scipy", &keys, true);
    }
    Ok(())
}

/// Keeping the largest component of the head, from the command to the step of history, and taking it back.
pub fn isolate(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    let mut document = over(head_values([N as u32; 3])?, N as u32, folder.path())?;
    let function = json!({"colour": [[0, [1, 1, 1]]], "opacity": [[39, 0], [40, 0.5]], "unit_mm": 1});
    apply(&mut document, json!({"transfer": {"set": {"function": function}}}))?;
    let mut said = json!(null);
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..7 {
        times[0].push(measure(0, 1, |_| -> Result<(), Failure> {
            said = apply(&mut document, json!({"component": {"keep": {}}}))?;
            Ok(())
        })?);
        times[1].push(measure(0, 1, |_| apply(&mut document, json!({"history": {"undo": {}}})).map(drop))?);
    }
    let [keep, undo] = times.map(Time::median);
    let keys = [("kind", json!("components")), ("mask", json!("head")), ("components", said["components"].clone())];
    report.beside("keep the head's largest of 256³", keep, "scipy's labels alone", &keys, true);
    report.row("undo it", undo, &format!("{} voxels in {} bricks", said["voxels_changed"], said["bricks_touched"]));
    Ok(())
}

/// The surfaces of the head's largest component, selected and labelled, to files.
pub fn surfaces(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    let mut document = over(head_values([N as u32; 3])?, N as u32, folder.path())?;
    let matter = json!({"range": [40, 254]});
    apply(&mut document, json!({"component": {"select": {"matter": matter}}}))?;
    apply(&mut document, json!({"component": {"label": {"matter": matter, "label": 1}}}))?;
    for field in ["selection", "labels"] {
        let path = folder.path().join("out.stl");
        let mut said = json!(null);
        let time = measure(1, 3, |_| -> Result<(), Failure> {
            said = apply(&mut document, json!({"volume": {"export": {"field": field, "path": path}}}))?;
            Ok(())
        })?;
        report.row(
            &format!("surface of {field} to STL, 256³"),
            time,
            &format!("{} triangles", said["exported"]["triangles"]),
        );
    }
    Ok(())
}

fn brick(mask: &[u8], index: BrickIndex) -> BrickMask {
    let [x, y, z] = index.origin().map(|o| o as usize);
    BrickMask::new([BRICK; 3], |[i, j, k]| mask[x + i as usize + N * (y + j as usize + N * (z + k as usize))] != 0)
}

fn noise() -> Vec<f32> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    (0..N * N * N).map(|_| rng.random_range(0.0..1.0)).collect()
}

/// Means of three neighbours along each axis, three times over; they stay about a half. The border's neighbour is itself.
fn smoothed(mut values: Vec<f32>) -> Vec<f32> {
    for stride in [1, N, N * N].repeat(3) {
        let before = values.clone();
        for (i, value) in values.iter_mut().enumerate() {
            let at = i / stride % N;
            let low = if at > 0 { before[i - stride] } else { before[i] };
            let high = if at + 1 < N { before[i + stride] } else { before[i] };
            *value = (low + before[i] + high) / 3.0;
        }
    }
    values
}
