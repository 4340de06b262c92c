//! Numbers that shaders and host share, said once: the module `burin::constants` is written from here.
//!
//! Owns names, types and values; whoever needs one on the host takes it from here too. Shared structs are in `layout`.

/// Declares constants for Rust and writes the same ones in WGSL.
macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident: $ty:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $ty = $value;)*

        /// The source of the shaders' module `burin::constants`.
        pub(crate) fn source() -> String {
            let mut source = String::from("#define_import_path burin::constants\n");
            $(source.push_str(&format!("const {}: {} = {:?};\n", stringify!($name), stringify!($ty), $value));)*
            source
        }
    };
}

shared! {
    /// Bodies that fit into one picture.
    MOST_BODIES: u32 = 512;
    /// Cutting planes of all bodies together that fit into one picture.
    MOST_PLANES: u32 = 4096;
    /// Boxes of finer volumes, as often as their hosts are posed, that fit into one picture.
    MOST_HOLES: u32 = 128;
    /// A body that is none of them.
    NO_HOLE: u32 = u32::MAX;
    /// Set in the object of a pixel whose ray meets a box of a finer volume.
    THROUGH_HOLE: u32 = 1 << 30;
    /// Pixels along an edge of a tile.
    TILE: u32 = 8;
    /// Entries in a row of the tiles' lists.
    LIST_WIDTH: u32 = 2048;
    /// Set in a tile's count where its bodies have no order and must be merged.
    MERGE_MARK: u32 = 1 << 30;
    /// Volumes that one picture can show.
    MOST_VOLUMES: u32 = 64;
    /// Pages in a row of the texture of page tables.
    PAGES_WIDTH: u32 = 2048;
    /// A body of direct volume rendering.
    MODE_DVR: u32 = 0;
    /// A body of which the surface at a density is drawn.
    MODE_ISO: u32 = 1;
    /// A body of which the maximum is drawn.
    MODE_MIP: u32 = 2;
    /// The column of the table of looks, behind their entries, that has their light.
    LOOK_LIGHT: u32 = crate::volume::TABLE_ENTRIES as u32;
    /// The column that has the opacity of their iso-surface.
    LOOK_OPACITY: u32 = crate::volume::TABLE_ENTRIES as u32 + 1;
    /// Where the looks of a body's labels begin that does not go by label.
    NO_ROWS: u32 = u32::MAX;
    /// Where the table of a field begins that has nothing on the GPU.
    NO_PAGES: u32 = u32::MAX;
    /// The depth of nothing, and a sample that no ray reaches.
    FAR: f32 = 3e38;
    /// Last entry of the table of colour and opacity.
    TABLE_LAST: f32 = (crate::volume::TABLE_ENTRIES - 1) as f32;
    /// The table's middle, from which places in it are weighed.
    TABLE_MIDDLE: f32 = (crate::volume::TABLE_ENTRIES / 2) as f32;
    /// Voxels along an edge of a brick.
    BRICK: u32 = crate::volume::BRICK;
    /// Texels along an edge of a slot: a brick and one voxel of apron on each side.
    SLOT: u32 = crate::volume::BRICK + 2;
    /// Meshes of a kind (opaque, cutting) that fit into one picture.
    MOST_MESHES: u32 = 64;
    /// What 1 means in the distances of a decal's finest level, in its texels; in every coarser one twice as much.
    MOST_DISTANCE: f32 = 128.0;
    /// A body takes the selected share of the matter in its region.
    MASK_SELECTION: u32 = 1;
    /// A body takes the share that is not selected.
    MASK_BACKGROUND: u32 = 2;
    /// Of every ray what lies before a ball is drawn, and all of one that misses it.
    KEEPS_BEFORE: u32 = 0;
    /// What lies inside it.
    KEEPS_INSIDE: u32 = 1;
    /// What lies behind it; nothing of a ray that misses it.
    KEEPS_BEHIND: u32 = 2;
    /// Transmittance under which a ray ends.
    CLEAR_END: f32 = 1.0 / 256.0;
    /// Dabs of one dispatch of the brush.
    MOST_DABS: u32 = 256;
    /// Slots of one dispatch of the brush.
    MOST_ITEMS: u32 = 128;
    /// Invocations of a workgroup of the brush, of which each takes a row of texels.
    ROWS_AT_ONCE: u32 = 64;
    /// Voxels along an edge of a cell.
    CELL: u32 = crate::volume::CELL;
    /// Cells along an edge of a block, of which a workgroup tells the extremes.
    BLOCK_CELLS: u32 = 4;
    /// Corrections of a surface particle after each of its steps.
    MOST_CORRECTIONS: u32 = 32;
    /// Bytes between rows in buffers that are copied to or from textures.
    ROW_PITCH_BYTES: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
    /// Words of a slot's bits that say which of its texels may be painted.
    GATE_WORDS: u32 = crate::paint::GATE_WORDS as u32;
}
