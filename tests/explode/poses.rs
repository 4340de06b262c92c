//! Parts that come, go or are let go of stand where what they were stood.

use super::{cube, octants};
use burin::explode::*;
use burin::math::{DQuat, DVec3, Plane, Pose};

fn pose(n: f64) -> Pose {
    Pose { rotation: DQuat::from_rotation_z(0.1 * n), translation: DVec3::new(n, -n, 2.0 * n) }
}

#[test]
fn halves_stand_where_the_whole_stood_and_the_others_where_they_did() {
    let before = octants(&cube(40));
    let given: Vec<Pose> = (1..=8).map(|i| pose(f64::from(i))).collect();
    let poses = Poses::found(&before.parts, &given);
    assert_eq!(poses.in_order(&before.parts), given);
    let mut after = before.clone();
    let [third, sixth] = [before.parts[2].id, before.parts[5].id];
    // Twice, so that the halves of halves are found too.
    for id in [third, sixth] {
        let middle = before.part(id).unwrap().centre();
        let plane = |normal: DVec3| Plane::through(middle, normal).unwrap();
        let [a, _] = after.split_at_rest(id, &plane(DVec3::new(1.0, 2.0, 3.0))).unwrap().unwrap();
        after.split_at_rest(a, &plane(DVec3::new(3.0, 1.0, -1.0))).unwrap().unwrap();
    }
    let now = poses.carried(&before, &after);
    for part in &after.parts {
        let whole = before.holding(part.centre()).unwrap();
        let i = before.parts.iter().position(|p| p.id == whole.id).unwrap();
        assert_eq!(now.of(part), given[i], "{}", part.name);
    }
    assert_eq!(after.parts.len(), 12);
}

#[test]
fn a_whole_that_was_made_of_all_stands_at_rest() {
    let before = octants(&cube(40));
    let poses = Poses::found(&before.parts, &vec![pose(3.0); 8]);
    let mut whole = Explosion::whole(&cube(40));
    whole.parts[0].id = PartId(99);
    assert_eq!(poses.carried(&before, &whole), Poses::default());
    // Also one part that is made anew.
    let one = Explosion::whole(&cube(40));
    let poses = Poses::found(&one.parts, &[pose(3.0)]);
    assert_eq!(poses.carried(&one, &whole), Poses::default());
}

#[test]
fn a_hand_goes_before_what_was_found_and_what_it_lets_go_of_stays() {
    let mut held = octants(&cube(40));
    let free = held.clone();
    let id = held.parts[4].id;
    held.place(id, pose(1.0)).unwrap();
    let found = Poses::found(&free.parts, &vec![pose(2.0); 8]);
    assert_eq!(found.of(&held.parts[4]), held.parts[4].held.unwrap());
    let in_hand = found.carried(&free, &held);
    assert_eq!(in_hand.told(&held.parts)[3], PartPose { id: held.parts[3].id, pose: pose(2.0) });
    let let_go = in_hand.carried(&held, &free);
    assert_eq!(let_go.of(&free.parts[4]), held.parts[4].held.unwrap());
    assert!(!let_go.at_rest(&free.parts) && Poses::default().at_rest(&free.parts));
    assert!(Poses::default().is_empty() && !Poses::default().at_rest(&held.parts), "held is not at rest");
}

#[test]
fn a_part_in_json_is_what_it_was_and_says_where_it_stands() {
    let mut explosion = octants(&cube(20));
    let id = explosion.parts[1].id;
    explosion.place(id, pose(1.0)).unwrap();
    for part in &explosion.parts {
        let json = serde_json::to_value(part).unwrap();
        assert_eq!(json["pinned"], part.held.is_some());
        assert_eq!(json["pose"], serde_json::to_value(part.held.unwrap_or_default()).unwrap());
        assert_eq!(serde_json::from_value::<Part>(json).unwrap(), *part);
        // What earlier programs wrote of a part that forces had moved.
        let moved = serde_json::to_value(PartRecord::of(part, pose(5.0))).unwrap();
        assert_eq!(serde_json::from_value::<Part>(moved).unwrap().held, part.held.map(|_| pose(5.0)));
    }
}
