//! The one way from files under `shaders/` to a module: imports resolved, conditions decided, validated.
//!
//! Owns the list of the library's files (embedded, so that the program needs none on disk; files with entry points make themselves
//! known) and the composer (naga_oil). Program and
//! tests call the same [`compose`]; a pipeline is specialised by `defs` instead of branching on the GPU. Two rules of the
//! composer: names of a library module do not end in a digit, and an imported name must not also be a member's name.

use crate::gpu::device::constants;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::shared;
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor};
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

pub use naga_oil::compose::ShaderDefValue as Def;

macro_rules! files {
    ($($path:literal),* $(,)?) => { &[$(($path, include_str!(concat!("../../../shaders/", $path)))),*] };
}

/// Modules that others import, each after those it imports itself; before all of them come the `constants`.
const LIBRARY: &[(&str, &str)] = files![
    "lib/field.wgsl",
    "lib/body.wgsl",
    "lib/picture.wgsl",
    "lib/layers.wgsl",
    "lib/look.wgsl",
    "lib/holes.wgsl",
    "lib/light.wgsl",
    "lib/mesh.wgsl",
    "lib/span.wgsl",
    "lib/dvr.wgsl",
    "lib/iso.wgsl",
    "lib/mip.wgsl",
    "lib/fade.wgsl",
    "lib/modes.wgsl",
    "lib/march.wgsl",
    "lib/events.wgsl",
    "lib/gathered.wgsl",
    "lib/merge.wgsl",
    "lib/stroke.wgsl",
    "lib/coverage.wgsl",
    "lib/equation.wgsl",
    "lib/equation_floats.wgsl",
    "lib/equation_colour.wgsl",
];

/// A file with entry points, made known by [`shader!`] where its kernel is.
#[derive(Debug)]
pub struct Source {
    /// Name under `shaders/`.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
    /// Conditions of which exactly one is set; none for most.
    pub one_of: &'static [&'static str],
}
inventory::collect!(Source);

/// The name of a shader file with entry points, which this embeds and makes known. `one of` names conditions of which exactly one is
/// set.
macro_rules! shader {
    ($file:literal $(, one of $($condition:literal),+)?) => {{
        inventory::submit! {
            $crate::gpu::device::shader::Source {
                file: $file,
                text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $file)),
                one_of: &[$($($condition),+)?],
            }
        }
        $file
    }};
}
pub(crate) use shader;

fn source(file: &str) -> Option<&'static Source> {
    inventory::iter::<Source>.into_iter().find(|s| s.file == file)
}

static COMPOSER: Mutex<Option<Composer>> = Mutex::new(None);

/// The files with entry points, by name under `shaders/`, in order.
pub fn kernels() -> impl Iterator<Item = &'static str> {
    let files: std::collections::BTreeSet<_> = inventory::iter::<Source>.into_iter().map(|s| s.file).collect();
    files.into_iter()
}

/// Conditions of a kernel of which exactly one is set; none for most kernels.
pub fn one_of(file: &str) -> &'static [&'static str] {
    source(file).map_or(&[], |s| s.one_of)
}

/// The conditions (`#ifdef`) that a kernel and what it imports ask for, in order.
pub fn conditions(file: &str) -> Vec<&'static str> {
    let mut sources: Vec<&'static str> = source(file).map(|s| s.text).into_iter().collect();
    let mut found = std::collections::BTreeSet::new();
    let mut seen = std::collections::BTreeSet::new();
    while let Some(source) = sources.pop() {
        for line in source.lines().map(str::trim) {
            let condition = line.strip_prefix("#else ").unwrap_or_else(|| line.trim_start_matches('#'));
            found.extend(condition.strip_prefix("ifdef ").or_else(|| condition.strip_prefix("ifndef ")).map(str::trim));
            if let Some(import) = line.strip_prefix("#import burin::") {
                let module = import.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
                let path = format!("lib/{module}.wgsl");
                if seen.insert(path.clone()) {
                    sources.extend(LIBRARY.iter().filter(|l| l.0 == path).map(|l| l.1));
                }
            }
        }
    }
    found.into_iter().collect()
}

/// Resolves a kernel's imports and conditions and validates the result. `defs` name what is defined (`#ifdef`), with a value
/// for `#if`.
///
/// # Errors
/// [`GpuError::Shader`] with the compiler's report.
pub fn compose(file: &str, defs: &[(&str, Def)]) -> Result<wgpu::naga::Module, GpuError> {
    let source = source(file).ok_or_else(|| GpuError::Shader {
        file: file.to_string(),
        reason: "no kernel of the program names it".to_string(),
    })?;
    compose_source(file, source.text, defs)
}

/// The same for a source that is not in the list, as tests have.
///
/// # Errors
/// As [`compose`].
pub fn compose_source(file: &str, source: &str, defs: &[(&str, Def)]) -> Result<wgpu::naga::Module, GpuError> {
    let mut guard = COMPOSER.lock().unwrap_or_else(PoisonError::into_inner);
    let composer = match guard.take() {
        Some(composer) => guard.insert(composer),
        None => guard.insert(library()?),
    };
    let descriptor = NagaModuleDescriptor {
        source,
        file_path: file,
        shader_defs: defs.iter().map(|&(name, value)| (name.to_string(), value)).collect(),
        ..Default::default()
    };
    match composer.make_naga_module(descriptor) {
        Ok(module) => Ok(module),
        Err(error) => Err(GpuError::Shader { file: file.to_string(), reason: error.emit_to_string(composer) }),
    }
}

fn library() -> Result<Composer, GpuError> {
    let mut composer = Composer::default();
    let (constants, structs) = (constants::source(), shared::source());
    let written = [("lib/constants.wgsl", constants.as_str()), ("lib/structs.wgsl", structs.as_str())];
    for (path, source) in written.iter().chain(LIBRARY) {
        let descriptor =
            ComposableModuleDescriptor { source, file_path: path, shader_defs: HashMap::new(), ..Default::default() };
        if let Err(error) = composer.add_composable_module(descriptor) {
            return Err(GpuError::Shader { file: (*path).to_string(), reason: error.emit_to_string(&composer) });
        }
    }
    Ok(composer)
}

/// [`compose`], handed to the device.
///
/// # Errors
/// [`GpuError::Shader`]; the device's own refusal as [`GpuError::Refused`].
pub fn compile(gpu: &Gpu, file: &str, defs: &[(&str, Def)]) -> Result<wgpu::ShaderModule, GpuError> {
    module(gpu, file, compose(file, defs)?)
}

/// [`compose_source`], handed to the device.
///
/// # Errors
/// As [`compile`].
pub fn compile_source(
    gpu: &Gpu,
    file: &str,
    source: &str,
    defs: &[(&str, Def)],
) -> Result<wgpu::ShaderModule, GpuError> {
    module(gpu, file, compose_source(file, source, defs)?)
}

fn module(gpu: &Gpu, file: &str, module: wgpu::naga::Module) -> Result<wgpu::ShaderModule, GpuError> {
    gpu.scoped(file, || {
        Ok(gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(file),
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
        }))
    })
}
