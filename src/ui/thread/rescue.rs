//! What is offered when something went wrong that the user can put right: another way to save, the file that is missing, the
//! document again after the part of the program that keeps it has failed.
//!
//! Knows why commands are refused; the question itself is `dialogs`'.

use crate::document::{Command, DensityKeeping, Document, DocumentError, KeepError, ProjectCommand, SubVolumeCommand};
use crate::ui::thread::session::{Offer, Then};
use std::any::Any;

/// A way out of a refusal, if there is one beside trying again.
pub(crate) fn way_out(command: &Command, error: &DocumentError) -> Option<Offer> {
    if let (Command::SubVolume(SubVolumeCommand::Set { volume, lo, hi, scale, .. }), DocumentError::WouldLose(lost)) =
        (command, error)
    {
        let (volume, lo, hi, scale) = (*volume, *lo, *hi, *scale);
        let set = SubVolumeCommand::Set { volume, lo, hi, scale, discard: true };
        return Some(Offer {
            title: "What was painted outside the smaller box will be lost".into(),
            text: format!(
                "{lost} samples of the sub-volume that were edited lie outside of it. Undo brings them back."
            ),
            then: Then::Do("Make it smaller".into(), Command::SubVolume(set)),
        });
    }
    let DocumentError::Keep(error) = error else { return None };
    match (command, error) {
        (
            Command::Project(ProjectCommand::Save { path, .. }),
            KeepError::LinkLost { .. } | KeepError::NotUtf8 { .. },
        ) => {
            let save = ProjectCommand::Save { path: path.clone(), density: Some(DensityKeeping::Whole) };
            Some(Offer {
                title: "The volume's file is not what it was".into(),
                text: error.to_string(),
                then: Then::Do("Keep the volume in the project".into(), Command::Project(save)),
            })
        }
        (
            Command::Project(ProjectCommand::Open { path, .. }),
            KeepError::SourceMissing { .. } | KeepError::SourceChanged { .. },
        ) => Some(Offer {
            title: "The project's volume is not there".into(),
            text: error.to_string(),
            then: Then::FindSource(path.clone()),
        }),
        (Command::Project(ProjectCommand::Open { path, source, .. }), KeepError::Damaged { whole, .. }) => {
            let (path, source) = (path.clone(), source.clone());
            let open = ProjectCommand::Open { path, source, generation: Some(*whole) };
            Some(Offer {
                title: "The project is damaged".into(),
                text: error.to_string(),
                then: Then::Do(format!("Open generation {whole}"), Command::Project(open)),
            })
        }
        _ => None,
    }
}

/// What is said of a failure inside the program, and what is offered.
pub(crate) fn after_failure(document: &Document, payload: &(dyn Any + Send)) -> (String, Option<Offer>) {
    let text = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
    let said = text.unwrap_or("no reason given");
    let failed = format!("The part of the program that keeps the document has failed: {said}.");
    if !document.is_kept() {
        return (format!("{failed} The document was closed; what was not saved of it is lost."), None);
    }
    let text = format!("{failed} The document was closed; every finished step of it is on disk.");
    let then = match document.project_dir() {
        Some(dir) => {
            let open = ProjectCommand::Open { path: dir.to_owned(), source: None, generation: None };
            Then::Do("Open it again".into(), Command::Project(open))
        }
        None => Then::Do("Show unsaved work".into(), Command::Project(ProjectCommand::Lost {})),
    };
    let title = "Something in the program has failed".into();
    (text.clone(), Some(Offer { title, text, then }))
}
