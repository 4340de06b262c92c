//! What a document answers, as a window hears it.

use burin::document::answers::{Answer, Lost, LostSaid, OpenedSaid, RecoveredSaid, Said, SavedSaid, StrokeFate};
use burin::document::answers_ask::VolumeSaid;
use burin::document::{Command, ProjectCommand, Saved};
use burin::ui::Report;
use burin::volume::{Number, TexelFormat, VoxelType};
use std::time::{Duration, SystemTime};

/// A command is done and says this.
pub fn said(command: Command, said: impl Into<Said>) -> Report {
    Report::Done(Box::new(command), Box::new(Answer::from(said.into())))
}

/// A command is done and has nothing to say that the window reads.
pub fn done(command: Command) -> Report {
    said(command, Said::Nothing)
}

/// A save is done, there.
pub fn saved(command: Command, path: Option<&str>) -> Report {
    let saved = Saved { generation: 1, bytes_written: 0, files_linked: 0 };
    said(command, SavedSaid { saved, path: path.map(str::to_owned) })
}

/// Crashes have left these documents behind, by id and file, a while ago.
pub fn lost(documents: &[(&str, &str)], ago: Duration) -> Report {
    let each = |(id, origin): &(&str, &str)| Lost {
        id: (*id).into(),
        origin: origin.into(),
        changed: SystemTime::now() - ago,
        bytes: 1,
    };
    said(Command::Project(ProjectCommand::Lost {}), LostSaid { lost: documents.iter().map(each).collect() })
}

/// Something was opened that was not saved when the program ended, its stroke running.
pub fn recovered(command: Command, steps: u64) -> Report {
    let volume = VolumeSaid {
        name: "head".into(),
        dims: [1; 3],
        voxel_type: VoxelType::U8,
        world_from_index: [[0.0; 4]; 3],
        spacing_mm: [1.0; 3],
        min: None,
        max: None,
        sum: Number::Whole(0),
        nan_count: 0,
        texels: TexelFormat::R16Unorm,
        half_step: 0.0,
        levels: 1,
    };
    let recovered = RecoveredSaid { steps, last: serde_json::Value::Null, stroke: StrokeFate::Painted, torn_bytes: 0 };
    let warnings = Vec::new();
    said(
        command,
        OpenedSaid { volume: Some(volume), labels: None, selected_voxels: None, warnings, recovered: Some(recovered) },
    )
}
