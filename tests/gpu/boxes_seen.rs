//! What hides what where volumes have boxes of a resolution of their own, among meshes that cut, beside counts by the book.

use super::reference_family::{Book, Family, parent_on, waves};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Caster, CutMesh, FieldPools, Frame, Gpu, Layers, Mask, Visibility};
use burin::math::{Aabb, DVec2, DVec3, Plane, Pose};
use burin::mesh::TriangleMesh;
use burin::volume::*;
use std::sync::Arc;

const DIMS: [u32; 3] = [36, 32, 28];

/// A box and one in it, all with a ball of their own that is selected.
fn family(scale: [u32; 2]) -> Family {
    let outer = SubBox { lo: [10, 10, 8], hi: [24, 22, 20], scale: [scale[0]; 3] };
    let inner = SubBox { lo: outer.dims().map(|n| n / 2), hi: outer.dims().map(|n| n - 1), scale: [scale[1]; 3] };
    let mut family = Family::new(parent_on(unit_grid(DIMS), waves), &[(0, outer), (1, inner)]);
    for volume in &mut family.volumes {
        let grid = *volume.grid();
        volume.selection = painted(FieldKind::Selection, &grid, move |v| {
            let at = DVec3::from_array(v.map(f64::from));
            let off = grid.world_from_index.transform_point3(at).distance(DVec3::new(18.0, 15.0, 14.0));
            [((9.0 - off) * 90.0).clamp(0.0, 255.0) as u8, 0, 0, 0]
        });
    }
    family
}

/// The selection, and three parts about it, two of them moved.
fn parted() -> Frame {
    let cut = |x: f64| Plane { normal: DVec3::new(1.0, 0.3, 0.1).normalize(), offset: x };
    let part = |id, region: Vec<Plane>, y: f64| {
        let pose = Pose { translation: DVec3::new(0.0, y, 0.0), ..Pose::IDENTITY };
        Body { region, pose, mask: Mask::Background, ..Body::whole(id) }
    };
    let (a, b) = (cut(16.0), cut(22.0));
    Frame {
        bodies: vec![
            part(1, vec![a], -6.0),
            part(2, vec![a.flipped(), b], 0.0),
            part(3, vec![b.flipped()], 9.0),
            Body { mask: Mask::Selection, ..Body::whole(9) },
        ],
        transfer: TransferFunction { opacity: vec![(1000.0, 0.0), (3000.0, 0.6)], ..ramp(1500.0, 3500.0) },
        ..frame(&unit_grid(DIMS), ramp(1500.0, 3500.0), DVec3::new(0.4, -1.0, 0.5), [56, 48])
    }
}

fn count(gpu: &Gpu, family: &Family, frame: &Frame) -> Visibility {
    let mut pools = FieldPools::empty(gpu, 256 << 20).unwrap();
    Caster::new(gpu).unwrap().visibility(gpu, &mut pools, &family.fields(), frame).unwrap()
}

fn by_the_book(family: &Family, frame: &Frame, cut: Option<Aabb>) -> Visibility {
    let book = Book::of(family);
    let mut counted = Visibility { hidden_by: vec![(1, 0), (2, 0), (3, 0)], ..Visibility::default() };
    for (x, y) in (0..frame.size[0]).flat_map(|x| (0..frame.size[1]).map(move |y| (x, y))) {
        let ray = frame.camera.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), frame.size);
        let is_left = |t: f64| cut.is_none_or(|b| (0..3).any(|a| ray.at(t)[a] < b.min[a] || ray.at(t)[a] > b.max[a]));
        let fading = |body: &Body| book.fading(frame, body, &ray).into_iter().filter(|s| is_left(s.0));
        let mut clear = 1.0;
        let reached = fading(&frame.bodies[3]).find(|(_, through)| {
            clear *= through;
            clear <= 0.5
        });
        let Some((reached, _)) = reached else { continue };
        counted.selected += 1;
        let mut clear = 1.0;
        for (body, hidden) in frame.bodies[..3].iter().zip(&mut counted.hidden_by) {
            let own: f64 = fading(body).filter(|s| s.0 < reached).map(|s| s.1).product();
            hidden.1 += u64::from(own <= 0.95);
            clear *= own;
        }
        counted.visible += u64::from(1.0 - clear < 0.05);
    }
    counted
}

#[test]
fn how_much_of_a_selection_is_seen_heeds_boxes_and_meshes_that_cut() {
    let Some(gpu) = gpu() else { return };
    let bounds = Aabb { min: DVec3::new(-20.0, 13.0, 11.0), max: DVec3::new(21.0, 70.0, 50.0) };
    let mesh = CutMesh { id: 0, mesh: Arc::new(TriangleMesh::cuboid(&bounds)), pose: Pose::IDENTITY };
    for scale in [[2, 3], [1, 1]] {
        let family = family(scale);
        let mut seen = Vec::new();
        for cut in [None, Some(bounds)] {
            let cuts = cut.iter().map(|_| mesh.clone()).collect();
            let plain = Frame { layers: Layers { cuts, ..Layers::default() }, ..parted() };
            let boxed = family.with_boxes(&plain);
            let counted = count(&gpu, &family, &boxed);
            let book = by_the_book(&family, &boxed, cut);
            let close = |a: u64, b: u64| a.abs_diff(b) <= 2;
            assert!(
                close(counted.selected, book.selected) && close(counted.visible, book.visible),
                "{counted:?} {book:?}"
            );
            assert_eq!(counted.hidden_by.len(), 3, "a part is named once: {counted:?}");
            for (own, of_book) in counted.hidden_by.iter().zip(&book.hidden_by) {
                assert!(own.0 == of_book.0 && close(own.1, of_book.1), "{counted:?} {book:?}");
            }
            seen.push(book);
        }
        // The cut takes something of what is selected and of what hides it.
        assert!(seen[0].selected > seen[1].selected + 20 && seen[1].visible > 10, "{seen:?}");
    }
}
