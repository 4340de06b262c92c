// A pixel's marks by their distance along its ray; those at one distance by colour and body, so that it does not matter in which order
// they were laid.

#import burin::body::view
#import burin::structs::Mark

@group(2) @binding(0) var<storage, read_write> heads: array<u32>;
@group(2) @binding(1) var<storage, read_write> marks: array<Mark>;

fn comes_before(a: Mark, b: Mark) -> bool {
    if (a.at != b.at) {
        return a.at < b.at;
    }
    return a.colour < b.colour || (a.colour == b.colour && a.body < b.body);
}

// Takes every mark out of the list as it was laid and puts it into its place in a new one.
@compute @workgroup_size(8, 8)
fn sort(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= view.width || id.y >= view.height) {
        return;
    }
    let head = 1u + id.y * view.width + id.x;
    var left = heads[head];
    var first = 0u;
    loop {
        if (left == 0u) {
            break;
        }
        let taken = left;
        let mark = marks[taken - 1u];
        left = mark.next;
        var before = 0u;
        var after = first;
        loop {
            if (after == 0u || comes_before(mark, marks[after - 1u])) {
                break;
            }
            before = after;
            after = marks[after - 1u].next;
        }
        marks[taken - 1u].next = after;
        if (before == 0u) {
            first = taken;
        } else {
            marks[before - 1u].next = taken;
        }
    }
    heads[head] = first;
}
