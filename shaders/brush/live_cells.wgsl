// Minima and maxima of the cells of painted slots, so that skipping and forces follow a stroke that is still running.
// A workgroup takes a block of cells and the texels around it: row by row along x, then for each cell the rows that it takes part of.

#import burin::constants::{BLOCK_CELLS, CELL}
#import burin::structs::CellsJob

// Texels along an edge of a block, one more on each side.
const EDGE: u32 = BLOCK_CELLS * CELL + 2u;
const ROWS: u32 = EDGE * EDGE;
// A value for each row and each cell along it.
const VALUES: u32 = ROWS * BLOCK_CELLS;
const CELLS: u32 = BLOCK_CELLS * BLOCK_CELLS * BLOCK_CELLS;
// Texels along an edge of a cell with those around.
const AROUND: u32 = CELL + 2u;
const NOTHING: u32 = 0xffffffffu;
// Of no voxel: least code 255, greatest 0, sum 0.
const NO_VOXEL: u32 = 0x00ff0000u;

@group(0) @binding(0) var pool: texture_3d<f32>;
@group(0) @binding(1) var<storage, read> jobs: array<CellsJob>;
// Three words a cell: least and greatest texel as ordered keys, least above greatest if there is none; the selection's codes.
@group(0) @binding(2) var<storage, read_write> cells: array<u32>;

var<workgroup> least: array<u32, VALUES>;
var<workgroup> greatest: array<u32, VALUES>;
#ifdef SELECTION
var<workgroup> codes: array<u32, VALUES>;
#endif

// A key that is ordered like the floats.
fn ordered(bits: u32) -> u32 {
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

fn take(i: u32, key: u32) {
    least[i] = min(least[i], key);
    greatest[i] = max(greatest[i], key);
}

// Sum in the lower 16 bits, least in the next 8, greatest above.
fn both(a: u32, b: u32) -> u32 {
    let low = min(a & 0xff0000u, b & 0xff0000u);
    let top = max(a & 0xff000000u, b & 0xff000000u);
    return top | low | ((a & 0xffffu) + (b & 0xffffu));
}

@compute @workgroup_size(CELLS)
fn cells_of_block(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let job = jobs[group.x];
    let own = (vec3<u32>(job.own) >> vec3<u32>(0u, 5u, 10u)) & vec3<u32>(31u);
    for (var row = local; row < ROWS; row += CELLS) {
        let first = row * BLOCK_CELLS;
        for (var c = first; c < first + BLOCK_CELLS; c += 1u) {
            least[c] = NOTHING;
            greatest[c] = 0u;
#ifdef SELECTION
            codes[c] = NO_VOXEL;
#endif
        }
        let y = row % EDGE;
        let z = row / EDGE;
        let inside = y >= 1u && y <= own.y && z >= 1u && z <= own.z;
        for (var x = 0u; x < EDGE; x += 1u) {
            let value = textureLoad(pool, job.at + vec3<u32>(x, y, z), 0).r;
            let bits = bitcast<u32>(value);
            // NaN counts for nothing.
            if (bits & 0x7fffffffu) <= 0x7f800000u {
                let key = ordered(bits);
                let cell = x / CELL;
                if cell < BLOCK_CELLS {
                    take(first + cell, key);
                }
                // The first two of a cell are the last two of the one before.
                if cell > 0u && x % CELL < 2u {
                    take(first + cell - 1u, key);
                }
            }
#ifdef SELECTION
            if inside && x >= 1u && x <= own.x {
                let code = u32(value * 255.0 + 0.5);
                let cell = first + (x - 1u) / CELL;
                codes[cell] = both(codes[cell], code | (code << 16u) | (code << 24u));
            }
#endif
        }
    }
    workgroupBarrier();
    let cell = vec3<u32>(local, local / BLOCK_CELLS, local / (BLOCK_CELLS * BLOCK_CELLS)) % BLOCK_CELLS;
    var lo = NOTHING;
    var hi = 0u;
    for (var i = 0u; i < AROUND * AROUND; i += 1u) {
        let row = (cell.z * CELL + i / AROUND) * EDGE + cell.y * CELL + i % AROUND;
        lo = min(lo, least[row * BLOCK_CELLS + cell.x]);
        hi = max(hi, greatest[row * BLOCK_CELLS + cell.x]);
    }
    let to = (group.x * CELLS + local) * 3u;
    cells[to] = lo;
    cells[to + 1u] = hi;
#ifdef SELECTION
    var all = NO_VOXEL;
    for (var i = 0u; i < CELL * CELL; i += 1u) {
        let row = (cell.z * CELL + 1u + i / CELL) * EDGE + cell.y * CELL + 1u + i % CELL;
        all = both(all, codes[row * BLOCK_CELLS + cell.x]);
    }
    cells[to + 2u] = all;
#else
    cells[to + 2u] = 0u;
#endif
}
