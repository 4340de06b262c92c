//! A transfer function under the hand stays one.

use burin::interact::curve::{add_colour, add_opacity, move_opacity, remove};
use burin::volume::TransferFunction;

fn function() -> TransferFunction {
    TransferFunction {
        colour: vec![(0.0, [0.0; 3]), (100.0, [1.0; 3])],
        opacity: vec![(10.0, 0.0), (50.0, 0.5), (90.0, 1.0)],
        unit_mm: 1.0,
    }
}

#[test]
fn a_dragged_point_never_passes_its_neighbours() {
    for value in [-1e9, 10.0, 50.0, 90.0, 1e9] {
        for i in 0..3 {
            let mut f = function();
            move_opacity(&mut f, i, value, 2.0, 1.0);
            f.check().unwrap();
            assert_eq!(f.opacity[i].1, 1.0, "opacity is clamped");
        }
    }
    let mut f = function();
    move_opacity(&mut f, 1, 70.0, 0.25, 1.0);
    assert_eq!(f.opacity[1], (70.0, 0.25));
    move_opacity(&mut f, 1, 200.0, 0.25, 1.0);
    assert_eq!(f.opacity[1].0, 89.0);
}

#[test]
fn neighbours_without_room_keep_a_point_where_it_is() {
    let mut f = function();
    f.opacity = vec![(10.0, 0.0), (10.5, 0.5), (11.0, 1.0)];
    move_opacity(&mut f, 1, 99.0, 0.5, 1.0);
    assert_eq!(f.opacity[1].0, 10.5);
}

#[test]
fn added_points_stand_in_order_and_a_colour_point_changes_no_colour() {
    let mut f = function();
    assert_eq!(add_opacity(&mut f, 60.0, 0.1, 1.0), Some(2));
    assert_eq!(add_opacity(&mut f, 60.5, 0.1, 1.0), None);
    let before = f.colour_at(25.0);
    assert_eq!(add_colour(&mut f, 25.0, 1.0), Some(1));
    assert_eq!(f.colour_at(25.0), before);
    f.check().unwrap();
}

#[test]
fn the_last_point_stays() {
    let mut f = function();
    for _ in 0..5 {
        remove(&mut f.opacity, 0);
    }
    assert_eq!(f.opacity.len(), 1);
}
