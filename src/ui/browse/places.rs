//! Where one goes often: home and its usual folders, disks that were plugged in, folders used lately.

use crate::ui::browse::names::shown;
use std::path::{Path, PathBuf};

/// A folder with a name of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// As it is shown.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
    /// It was used lately.
    pub recent: bool,
}

/// Places of this machine and user, then folders used lately, the last first. Asks the disk whether the usual ones are there.
pub fn places(home: Option<&Path>, recent: &[PathBuf]) -> Vec<Place> {
    let mut places: Vec<Place> = Vec::new();
    let mut add = |name: String, path: PathBuf, recent: bool| {
        if !places.iter().any(|p: &Place| p.path == path) {
            places.push(Place { name, path, recent });
        }
    };
    if let Some(home) = home {
        add("Home".into(), home.into(), false);
        for name in ["Desktop", "Documents", "Downloads"] {
            let path = home.join(name);
            if path.is_dir() {
                add(name.into(), path, false);
            }
        }
    }
    add("This computer".into(), PathBuf::from(std::path::MAIN_SEPARATOR_STR), false);
    let user = home.and_then(Path::file_name);
    for root in ["/media", "/run/media", "/mnt", "/Volumes"] {
        let root = Path::new(root);
        // Some systems give every user a folder there.
        let own = user.map(|user| root.join(user)).filter(|own| own.is_dir());
        for entry in std::fs::read_dir(own.as_deref().unwrap_or(root)).into_iter().flatten().flatten().take(16) {
            if entry.file_type().is_ok_and(|t| t.is_dir()) {
                add(shown(&entry.file_name()), entry.path(), false);
            }
        }
    }
    for path in recent {
        add(path.file_name().map_or_else(|| shown(path.as_os_str()), shown), path.clone(), true);
    }
    places
}
