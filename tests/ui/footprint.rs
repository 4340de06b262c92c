//! Outlines of a dab's form: every corner lies on the form and in the slice, and the silhouette touches it.

use burin::interact::Form;
use burin::math::{DVec2, DVec3};
use burin::paint::{Brush, Shape};

/// Distance to the middle as the form counts it, over the radius.
fn counted(form: &Form, at: DVec3) -> f64 {
    let offset = at - form.centre;
    let along = offset.dot(form.normal);
    ((offset - form.normal * along).length_squared() + (along / form.ratio).powi(2)).sqrt() / form.radius_mm
}

fn forms() -> Vec<Form> {
    let normal = DVec3::new(0.4, -0.3, 0.8).normalize();
    [1.0, 0.3, 1.8].map(|ratio| Form { centre: DVec3::new(3.0, -4.0, 7.0), radius_mm: 6.0, normal, ratio }).to_vec()
}

#[test]
fn where_a_form_meets_a_slice_its_outline_lies_on_both() {
    for form in forms() {
        for (right, up) in [(DVec3::X, DVec3::Y), (DVec3::NEG_Y, DVec3::Z), (DVec3::X, DVec3::Z)] {
            for lift in [0.0, 0.7, -1.5] {
                let normal = right.cross(up);
                let at = form.centre + normal * lift + right * 20.0 - up * 3.0;
                let corners = form.meets(at, right, up);
                assert!(!corners.is_empty(), "{form:?} {lift}");
                for DVec2 { x, y } in corners {
                    let x = counted(&form, at + right * x + up * y);
                    assert!((x - 1.0).abs() < 1e-9, "{form:?}: {x}");
                }
            }
            let far = form.centre + right.cross(up) * 6.0 * 1.8 * 1.01;
            assert!(form.meets(far, right, up).is_empty());
        }
    }
}

#[test]
fn a_silhouette_is_as_far_as_any_point_of_the_form() {
    for form in forms() {
        let sight = DVec3::new(0.2, 0.9, -0.4).normalize();
        let right = sight.any_orthonormal_vector();
        let up = right.cross(sight);
        let corners = form.silhouette(sight, right, up);
        // On the line of sight through a corner, the nearest that the form counts is its rim.
        for DVec2 { x, y } in corners {
            let foot = form.centre + right * x + up * y;
            let nearest = (-4000..=4000)
                .map(|i| counted(&form, foot + sight * (f64::from(i) * 0.004)))
                .fold(f64::INFINITY, f64::min);
            assert!((nearest - 1.0).abs() < 1e-4, "{form:?}: {nearest}");
        }
    }
}

#[test]
fn a_brushs_form_is_that_of_its_shape() {
    let slice = (DVec3::Y, 0.5);
    let normal = Some(DVec3::X);
    let of = |shape| Form::of(&Brush { shape, radius_mm: 5.0, ..Brush::default() }, DVec3::ZERO, normal, slice);
    assert_eq!(of(Shape::Sphere).ratio, 1.0);
    assert_eq!((of(Shape::Ellipsoid).ratio, of(Shape::Ellipsoid).normal), (0.5, DVec3::X));
    assert_eq!((of(Shape::Disc).ratio, of(Shape::Disc).normal), (0.1, DVec3::Y));
}
