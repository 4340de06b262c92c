//! Every shader under every condition: it composes, validates, and its buffers hold what Rust declares.

use burin::gpu::device::shader::{Def, compose, compose_source, conditions, kernels, one_of};
use burin::gpu::device::shared::{Declared, Kind};
use burin::gpu::shared_structs;
use wgpu::naga;

/// All subsets of few conditions; of many: none, all, each alone, each left out. Of those that exclude each other one each time.
fn variants(file: &str) -> Vec<Vec<(&'static str, Def)>> {
    let exclusive = one_of(file);
    let free: Vec<&'static str> = conditions(file).into_iter().filter(|c| !exclusive.contains(c)).collect();
    let n = free.len();
    let pick = |keep: &dyn Fn(usize) -> bool| (0..n).filter(|&i| keep(i)).map(|i| free[i]).collect::<Vec<_>>();
    let mut sets = Vec::new();
    if n <= 4 {
        sets.extend((0..1_usize << n).map(|set| pick(&|i| set >> i & 1 == 1)));
    } else {
        sets.extend([pick(&|_| false), pick(&|_| true)]);
        for one in 0..n {
            sets.extend([pick(&|i| i == one), pick(&|i| i != one)]);
        }
    }
    let defined = |set: &[&'static str]| set.iter().map(|&name| (name, Def::Bool(true))).collect::<Vec<_>>();
    if exclusive.is_empty() {
        return sets.iter().map(|s| defined(s)).collect();
    }
    let with = |set: &Vec<&'static str>, one: &'static str| defined(&[&set[..], &[one]].concat());
    sets.iter().flat_map(|set| exclusive.iter().map(|one| with(set, one))).collect()
}

/// The name without the composer's decoration.
fn plain(name: &str) -> &str {
    name.split("X_naga_oil_mod_X").next().unwrap()
}

fn scalar(module: &naga::Module, ty: naga::Handle<naga::Type>) -> Option<Kind> {
    let kind = |s: naga::Scalar| match (s.kind, s.width) {
        (naga::ScalarKind::Float, 4) => Kind::F32,
        (naga::ScalarKind::Uint, 4) => Kind::U32,
        (naga::ScalarKind::Sint, 4) => Kind::I32,
        other => panic!("scalar {other:?} in a buffer"),
    };
    match &module.types[ty].inner {
        naga::TypeInner::Scalar(s) | naga::TypeInner::Atomic(s) => Some(kind(*s)),
        naga::TypeInner::Vector { scalar, .. } | naga::TypeInner::Matrix { scalar, .. } => Some(kind(*scalar)),
        naga::TypeInner::Array { base, .. } => scalar(module, *base),
        naga::TypeInner::Struct { .. } => Some(Kind::Struct),
        _ => None,
    }
}

/// Compares a struct of a shader, and those inside it, with its declaration.
fn check(module: &naga::Module, ty: naga::Handle<naga::Type>, declared: &[Declared], place: &str) {
    match &module.types[ty].inner {
        naga::TypeInner::Array { base, .. } => check(module, *base, declared, place),
        naga::TypeInner::Struct { members, span } => {
            let name = plain(module.types[ty].name.as_deref().unwrap());
            let rust = declared.iter().find(|d| d.name == name);
            let rust = rust.unwrap_or_else(|| panic!("{place}: struct {name} is not declared in Rust"));
            assert_eq!(rust.size, *span as usize, "{place}: span of {name}");
            assert_eq!(rust.members.len(), members.len(), "{place}: members of {name}");
            for (r, w) in rust.members.iter().zip(members) {
                let at = format!("{place}: {name}.{}", r.name);
                assert_eq!(Some(r.name), w.name.as_deref(), "{at}");
                assert_eq!(r.offset, w.offset as usize, "{at}");
                let size = module.types[w.ty].inner.size(module.to_ctx());
                assert_eq!(r.size, size as usize, "{at}");
                assert_eq!(Some(r.kind), scalar(module, w.ty), "{at}");
                check(module, w.ty, declared, place);
            }
        }
        _ => {}
    }
}

#[test]
fn every_shader_composes_validates_and_shares_its_structs_with_rust() {
    let declared = shared_structs();
    let mut seen = std::collections::BTreeSet::new();
    for file in kernels() {
        for defs in variants(file) {
            let names: Vec<_> = defs.iter().map(|d| d.0).collect();
            let module = compose(file, &defs).unwrap_or_else(|e| panic!("{file} {names:?}: {e}"));
            let flags = naga::valid::ValidationFlags::all();
            let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::default());
            validator.validate(&module).unwrap_or_else(|e| panic!("{file} {names:?}: {e:?}"));
            assert!(!module.entry_points.is_empty(), "{file} has an entry point");
            for (_, global) in module.global_variables.iter() {
                if matches!(global.space, naga::AddressSpace::Uniform | naga::AddressSpace::Storage { .. }) {
                    check(&module, global.ty, &declared, file);
                    if let Some(name) = &module.types[global.ty].name {
                        seen.insert(plain(name).to_string());
                    }
                }
            }
            for entry in module.entry_points.iter().filter(|e| e.stage == naga::ShaderStage::Compute) {
                // Narrower in x is slower; more than 256 in all is not everywhere.
                let [x, y, z] = entry.workgroup_size;
                assert!(x % 8 == 0 && x * y * z <= 256, "{file} {}: {:?}", entry.name, entry.workgroup_size);
            }
        }
    }
    assert!(seen.contains("FieldInfo") && seen.contains("Slice"), "{seen:?}");
}

#[test]
fn every_file_with_entry_points_is_known() {
    let root = crate::common::root().join("shaders");
    let mut folders = vec![root.clone()];
    let mut found = std::collections::BTreeSet::new();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
            if path.is_dir() && name != "lib" {
                folders.push(path);
            } else if name.ends_with(".wgsl") {
                found.insert(name);
            }
        }
    }
    assert!(found.len() > 6);
    assert_eq!(kernels().map(str::to_string).collect::<std::collections::BTreeSet<_>>(), found);
}

#[test]
fn shaders_take_shared_numbers_from_rust() {
    use burin::gpu::device::constants as shared;
    let source = "#import burin::constants::{MOST_BODIES, TILE, LIST_WIDTH, MERGE_MARK, FAR, TABLE_LAST, SLOT}
        @group(0) @binding(0) var<storage, read_write> all: array<f32, MOST_BODIES>;
        @compute @workgroup_size(8) fn main() {
            all[TILE] = f32(LIST_WIDTH) + f32(MERGE_MARK) + FAR + TABLE_LAST + f32(SLOT);
        }";
    let module = compose_source("constants.wgsl", source, &[]).unwrap();
    let value = |name: &str| {
        let constant = module.constants.iter().find(|(_, c)| c.name.as_deref().map(plain) == Some(name));
        let (_, constant) = constant.unwrap_or_else(|| panic!("{name} is a constant of the module"));
        match module.global_expressions[constant.init] {
            naga::Expression::Literal(naga::Literal::F32(x)) => f64::from(x),
            naga::Expression::Literal(naga::Literal::U32(x)) => f64::from(x),
            ref other => panic!("{name}: {other:?}"),
        }
    };
    assert_eq!(value("FAR"), f64::from(shared::FAR));
    assert_eq!(value("TABLE_LAST"), f64::from(shared::TABLE_LAST));
    let whole = [("TILE", shared::TILE), ("LIST_WIDTH", shared::LIST_WIDTH), ("MERGE_MARK", shared::MERGE_MARK)];
    for (name, here) in whole.into_iter().chain([("SLOT", shared::SLOT), ("MOST_BODIES", shared::MOST_BODIES)]) {
        assert_eq!(value(name), f64::from(here), "{name}");
    }
}

#[test]
fn no_shader_that_draws_repeats_a_shared_number() {
    let folder = crate::common::root().join("shaders");
    for file in [folder.join("lib"), folder.join("cast"), folder].iter().flat_map(|f| std::fs::read_dir(f).unwrap()) {
        let path = file.unwrap().path();
        if path.is_dir() || path.file_name().unwrap().to_str().unwrap().starts_with("brush") {
            continue;
        }
        for (i, line) in std::fs::read_to_string(&path).unwrap().lines().enumerate() {
            let code = line.split("//").next().unwrap();
            let words: Vec<&str> = code.split(|c: char| !c.is_alphanumeric() && c != '.').collect();
            for number in ["34u", "33.5", "4095.0", "4095", "2048u", "512", "4096", "3.0e38"] {
                assert!(!words.contains(&number), "{}:{}: {number} stands by hand", path.display(), i + 1);
            }
        }
    }
}

#[test]
fn a_shader_that_does_not_compose_says_which_and_why() {
    let error = compose_source("broken.wgsl", "fn f() -> u32 { return nothing; }", &[]).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("broken.wgsl") && text.contains("nothing"), "{text}");
    let text = compose("missing.wgsl", &[]).unwrap_err().to_string();
    assert!(text.contains("missing.wgsl"), "{text}");
}
