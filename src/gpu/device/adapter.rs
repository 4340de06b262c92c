//! Which adapter is asked for a device, where the system has several.
//!
//! Owns [`AdapterChoice`] and the variable that says it. Knows adapters by what they say of themselves.

use std::fmt::Write;

/// The variable that names the adapter for pictures and strokes: part of its name, or `hardware`.
pub(crate) const VARIABLE: &str = "BURIN_ADAPTER";

/// Which adapter is wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// What the system thinks fastest, a software one where there is no other.
    #[default]
    Best,
    /// The first that is no software on the processor.
    Hardware,
    /// The first whose name contains this, whatever the case.
    Named(String),
}

impl AdapterChoice {
    /// As `BURIN_ADAPTER` says it; unset or empty: the best.
    pub fn from_env() -> Self {
        Self::from_words(&std::env::var(VARIABLE).unwrap_or_default())
    }

    /// As a person says it: nothing, `hardware`, or part of a name.
    pub fn from_words(words: &str) -> Self {
        match words.trim() {
            "" => Self::Best,
            "hardware" => Self::Hardware,
            name => Self::Named(name.to_owned()),
        }
    }

    /// The words that say it.
    pub fn words(&self) -> &str {
        match self {
            Self::Best => "",
            Self::Hardware => "hardware",
            Self::Named(name) => name,
        }
    }

    /// The place of the first adapter in the list that is wanted.
    ///
    /// # Errors
    /// A sentence with what was found, where none is.
    pub fn among(&self, adapters: &[wgpu::AdapterInfo]) -> Result<usize, String> {
        let software = |a: &wgpu::AdapterInfo| a.device_type == wgpu::DeviceType::Cpu;
        let (found, expected) = match self {
            Self::Best => ((!adapters.is_empty()).then_some(0), "any adapter"),
            Self::Hardware => (adapters.iter().position(|a| !software(a)), "a graphics card"),
            Self::Named(name) => {
                let holds = |a: &wgpu::AdapterInfo| a.name.to_lowercase().contains(&name.to_lowercase());
                (adapters.iter().position(holds), name.as_str())
            }
        };
        found.ok_or_else(|| {
            let mut words = format!("{expected} expected, found ");
            for (i, a) in adapters.iter().enumerate() {
                let comma = if i > 0 { ", " } else { "" };
                // Writing into a string cannot fail.
                let _ = write!(words, "{comma}{} ({:?}, {:?})", a.name, a.backend, a.device_type);
            }
            words + if adapters.is_empty() { "none" } else { "" }
        })
    }
}
