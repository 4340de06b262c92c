// Minima and maxima of the cells of painted slots, so that skipping and forces follow a stroke that is still running.
// A workgroup takes a block of 4^3 cells of 4^3 voxels, 18^3 texels with those around: row by row along x, then 36 rows a cell.

#import burin::structs::CellsJob

const ROWS: u32 = 324u;
const NOTHING: u32 = 0xffffffffu;
// Of no voxel: least code 255, greatest 0, sum 0.
const NO_VOXEL: u32 = 0x00ff0000u;

@group(0) @binding(0) var pool: texture_3d<f32>;
@group(0) @binding(1) var<storage, read> jobs: array<CellsJob>;
// Three words a cell: least and greatest texel as ordered keys, least above greatest if there is none; the selection's codes.
@group(0) @binding(2) var<storage, read_write> cells: array<u32>;

var<workgroup> least: array<u32, 1296>;
var<workgroup> greatest: array<u32, 1296>;
#ifdef SELECTION
var<workgroup> codes: array<u32, 1296>;
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

@compute @workgroup_size(64)
fn cells_of_block(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let job = jobs[group.x];
    let own = (vec3<u32>(job.own) >> vec3<u32>(0u, 5u, 10u)) & vec3<u32>(31u);
    for (var row = local; row < ROWS; row += 64u) {
        let first = row * 4u;
        for (var c = first; c < first + 4u; c += 1u) {
            least[c] = NOTHING;
            greatest[c] = 0u;
#ifdef SELECTION
            codes[c] = NO_VOXEL;
#endif
        }
        let y = row % 18u;
        let z = row / 18u;
        let inside = y >= 1u && y <= own.y && z >= 1u && z <= own.z;
        for (var x = 0u; x < 18u; x += 1u) {
            let value = textureLoad(pool, job.at + vec3<u32>(x, y, z), 0).r;
            let bits = bitcast<u32>(value);
            // NaN counts for nothing.
            if (bits & 0x7fffffffu) <= 0x7f800000u {
                let key = ordered(bits);
                let cell = x / 4u;
                if cell < 4u {
                    take(first + cell, key);
                }
                // The first two of a cell are the last two of the one before.
                if cell > 0u && x % 4u < 2u {
                    take(first + cell - 1u, key);
                }
            }
#ifdef SELECTION
            if inside && x >= 1u && x <= own.x {
                let code = u32(value * 255.0 + 0.5);
                let cell = first + (x - 1u) / 4u;
                codes[cell] = both(codes[cell], code | (code << 16u) | (code << 24u));
            }
#endif
        }
    }
    workgroupBarrier();
    let cell = vec3<u32>(local % 4u, (local / 4u) % 4u, local / 16u);
    var lo = NOTHING;
    var hi = 0u;
    for (var i = 0u; i < 36u; i += 1u) {
        let row = (cell.z * 4u + i / 6u) * 18u + cell.y * 4u + i % 6u;
        lo = min(lo, least[row * 4u + cell.x]);
        hi = max(hi, greatest[row * 4u + cell.x]);
    }
    let to = (group.x * 64u + local) * 3u;
    cells[to] = lo;
    cells[to + 1u] = hi;
#ifdef SELECTION
    var all = NO_VOXEL;
    for (var i = 0u; i < 16u; i += 1u) {
        let row = (cell.z * 4u + 1u + i / 4u) * 18u + cell.y * 4u + 1u + i % 4u;
        all = both(all, codes[row * 4u + cell.x]);
    }
    cells[to + 2u] = all;
#else
    cells[to + 2u] = 0u;
#endif
}
