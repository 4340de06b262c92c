//! Meshes against what they are of, reckoned one by one.

mod surfaces;

use burin::math::DVec3;
use burin::mesh::TriangleMesh;
use std::collections::HashMap;

pub fn corners(mesh: &TriangleMesh) -> Vec<DVec3> {
    mesh.corners().iter().map(|c| DVec3::from_array(c.map(f64::from))).collect()
}

/// Whether every edge is of two triangles, once each way, and whether what is around every corner is one ring.
pub fn is_manifold(mesh: &TriangleMesh) -> bool {
    let mut next: HashMap<(u32, u32), u32> = HashMap::new();
    let mut ways: HashMap<(u32, u32), u32> = HashMap::new();
    // Of each corner a neighbour, and how many triangles it has.
    let mut around: HashMap<u32, (u32, usize)> = HashMap::new();
    for &[a, b, c] in mesh.triangles() {
        for [own, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
            *ways.entry((own, from)).or_default() += 1;
            next.insert((own, from), to);
            around.entry(own).or_insert((from, 0)).1 += 1;
        }
    }
    let paired = ways.iter().all(|(&(a, b), n)| *n == 1 && ways.get(&(b, a)) == Some(&1));
    let rings = around.iter().all(|(&own, &(start, count))| {
        let (mut at, mut met) = (start, 0);
        loop {
            at = match next.get(&(own, at)) {
                Some(to) => *to,
                None => return false,
            };
            met += 1;
            if at == start || met > count {
                return met == count;
            }
        }
    });
    paired && rings
}

/// Corners less edges and triangles: twice the number of closed pieces less twice the holes through them.
pub fn euler(mesh: &TriangleMesh) -> i64 {
    let used: std::collections::BTreeSet<u32> = mesh.triangles().iter().flatten().copied().collect();
    used.len() as i64 - mesh.triangles().len() as i64 / 2
}

/// How often a mesh winds about a place: 1 inside, 0 outside (van Oosterom, Strackee 1983: the solid angle of a triangle).
pub fn winding(mesh: &TriangleMesh, corners: &[DVec3], at: DVec3) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| corners[i as usize] - at);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let over = a.dot(b.cross(c));
        let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * over.atan2(under)
    };
    mesh.triangles().iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}
