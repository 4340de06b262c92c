//! Structs that Rust and WGSL share, declared once.
//!
//! Owns the [`Shared`] trait and the `shared_struct!` macro: a `repr(C)` plain-old-data struct that can list its members as
//! WGSL sees them; shaders take them from the module `burin::structs`, which is written from here. A test reflects the shaders and compares. Vectors of three must be followed by a 4-byte member, so that
//! Rust's packing and WGSL's alignment agree.

/// A scalar's kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Kind {
    F32,
    U32,
    I32,
    /// Another shared struct.
    Struct,
}

/// A member of a shared struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Name in both languages.
    pub name: &'static str,
    /// Bytes from the struct's start.
    pub offset: usize,
    /// Bytes.
    pub size: usize,
    /// Kind of its scalars.
    pub kind: Kind,
    /// Its type in WGSL.
    pub wgsl: String,
}

/// A struct that shaders see under the same name.
pub trait Shared: bytemuck::Pod {
    /// Its name in WGSL.
    const NAME: &'static str;
    /// Its members in order.
    fn members() -> Vec<Member>;
}

/// A shared struct, described.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Declared {
    /// Name in both languages.
    pub name: &'static str,
    /// Bytes.
    pub size: usize,
    /// Members in order.
    pub members: Vec<Member>,
}

/// Describes a shared struct.
pub fn declared<T: Shared>() -> Declared {
    Declared { name: T::NAME, size: size_of::<T>(), members: T::members() }
}

/// A shared struct that `shared_struct!` makes known.
#[derive(Debug)]
pub struct Known(pub fn() -> Declared);

#[doc(hidden)]
pub use inventory;
inventory::collect!(Known);

/// Every struct that a shader's buffers hold, by name. A shader with another one fails a test.
pub fn all() -> Vec<Declared> {
    let mut all: Vec<Declared> = inventory::iter::<Known>.into_iter().map(|known| (known.0)()).collect();
    all.sort_by_key(|declared| declared.name);
    all
}

/// The source of the shaders' module `burin::structs`: all shared structs as shaders see them, those that others hold first.
pub(crate) fn source() -> String {
    let mut source = String::from("#define_import_path burin::structs\n");
    let mut left = all();
    while !left.is_empty() {
        let names: Vec<&str> = left.iter().map(|declared| declared.name).collect();
        let holds =
            |declared: &Declared| declared.members.iter().any(|m| names.iter().any(|name| m.wgsl.contains(name)));
        let (waiting, ready): (Vec<_>, Vec<_>) = left.iter().cloned().partition(holds);
        for Declared { name, members, .. } in &ready {
            let members: String = members.iter().map(|m| format!("    {}: {},\n", m.name, m.wgsl)).collect();
            source.push_str(&format!("struct {name} {{\n{members}}}\n"));
        }
        // Rust has no struct that holds itself, so every round has one that is ready.
        left = waiting;
    }
    source
}

/// A type that shaders have too.
pub trait Scalars {
    /// The kind of its scalars.
    const KIND: Kind;
    /// Whether it is a scalar: an array of 2 to 4 of them is a vector, an array of anything else an array.
    const IS_SCALAR: bool = false;
    /// Its name in WGSL.
    fn wgsl() -> String;
}
impl Scalars for f32 {
    const KIND: Kind = Kind::F32;
    const IS_SCALAR: bool = true;
    fn wgsl() -> String {
        "f32".into()
    }
}
impl Scalars for u32 {
    const KIND: Kind = Kind::U32;
    const IS_SCALAR: bool = true;
    fn wgsl() -> String {
        "u32".into()
    }
}
impl Scalars for i32 {
    const KIND: Kind = Kind::I32;
    const IS_SCALAR: bool = true;
    fn wgsl() -> String {
        "i32".into()
    }
}
impl<T: Scalars, const N: usize> Scalars for [T; N] {
    const KIND: Kind = T::KIND;
    fn wgsl() -> String {
        match (T::IS_SCALAR, N) {
            (true, 2..=4) => format!("vec{N}<{}>", T::wgsl()),
            _ => format!("array<{}, {N}>", T::wgsl()),
        }
    }
}

/// Declares a struct that is shared with WGSL, and makes it known: `shared_struct! { /// doc  pub struct Name { pub member: type, … } }`.
#[macro_export]
macro_rules! shared_struct {
    ($(#[$meta:meta])* $vis:vis struct $name:ident { $($(#[$m:meta])* $mvis:vis $member:ident : $ty:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        $vis struct $name { $($(#[$m])* $mvis $member: $ty,)* }

        $crate::gpu::device::shared::inventory::submit! {
            $crate::gpu::device::shared::Known($crate::gpu::device::shared::declared::<$name>)
        }

        impl $crate::gpu::device::shared::Scalars for $name {
            const KIND: $crate::gpu::device::shared::Kind = $crate::gpu::device::shared::Kind::Struct;
            fn wgsl() -> String {
                stringify!($name).to_owned()
            }
        }

        impl $crate::gpu::device::shared::Shared for $name {
            const NAME: &'static str = stringify!($name);
            fn members() -> Vec<$crate::gpu::device::shared::Member> {
                vec![$($crate::gpu::device::shared::Member {
                    name: stringify!($member),
                    offset: std::mem::offset_of!($name, $member),
                    size: std::mem::size_of::<$ty>(),
                    kind: <$ty as $crate::gpu::device::shared::Scalars>::KIND,
                    wgsl: <$ty as $crate::gpu::device::shared::Scalars>::wgsl(),
                },)*]
            }
        }
    };
}
