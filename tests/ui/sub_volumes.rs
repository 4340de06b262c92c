//! The tool for sub-volumes as a hand drives it: what a drag makes and moves, and what is said before the button goes up.

use super::interact::{Hand, SIZE};
use burin::document::{Command, Origin, Scale, SubVolume, SubVolumeCommand, ViewName, VolumeSettings};
use burin::interact::{Button, CutSlice, Mark, Tool};
use burin::math::DVec3;
use burin::volume::{SubBox, VolumeId};

const INNER: VolumeId = VolumeId(1);

/// Pixel of a place in index of the volume, 1 × 1 × 2 mm, on the axial slice.
fn pixel(hand: &Hand, index: [f64; 3]) -> [f64; 2] {
    let slice = CutSlice::new(&hand.grid, &hand.scene, ViewName::Axial, SIZE).unwrap();
    slice.plane.pixel(DVec3::from_array(index) * DVec3::new(1.0, 1.0, 2.0)).to_array()
}

fn note(hand: &Hand, view: ViewName) -> Option<String> {
    let marks = hand.interaction.gesture()?.marks(view);
    marks.into_iter().find_map(|mark| if let Mark::Note { text, .. } = mark { Some(text) } else { None })
}

/// A hand over the slice z = 16, with a box in the volume.
fn hand(of: Option<SubBox>) -> Hand {
    let mut hand = Hand::new(Tool::SubVolume, ViewName::Axial);
    hand.scene.views.crosshair = DVec3::new(32.0, 32.0, 32.0);
    hand.sample_bytes = [(VolumeId::FIRST, 9), (INNER, 11)].into();
    if let Some(of) = of {
        let mut settings = VolumeSettings::new("box", Origin { path: "small.nii".into(), component: 0, frame: 0 });
        settings.sub_volume = Some(SubVolume { parent: VolumeId::FIRST, of });
        hand.scene.volumes.all.insert(INNER, settings);
        let corner = |i: usize| {
            std::array::from_fn::<f64, 3, _>(|a| f64::from(if i >> a & 1 == 0 { of.lo[a] } else { of.hi[a] }))
        };
        let corners = std::array::from_fn(|i| DVec3::from_array(corner(i)) * DVec3::new(1.0, 1.0, 2.0));
        hand.boxes.insert(INNER, corners);
    }
    hand
}

#[test]
fn a_drag_over_a_slice_says_what_the_box_may_take_and_makes_it_when_the_button_goes_up() {
    let mut hand = hand(None);
    let (from, to) = (pixel(&hand, [10.2, 20.1, 16.0]), pixel(&hand, [29.8, 31.9, 16.0]));
    assert_eq!(hand.press(Button::Primary, from[0], from[1]), []);
    assert_eq!(hand.drag(to[0], to[1]), []);
    // 20 × 12 voxels; as thick as it is narrow: 12 mm, 6 voxels; 4 samples a voxel and one more.
    let wanted = SubBox { lo: [10, 20, 13], hi: [30, 32, 19], scale: [4; 3] };
    assert_eq!(note(&hand, ViewName::Axial).unwrap(), "81 × 49 × 25 samples, at most 893 kB");
    assert_eq!(note(&hand, ViewName::Coronal), None, "what the hand is not over says nothing");
    let add = SubVolumeCommand::Add {
        volume: None,
        lo: wanted.lo,
        hi: wanted.hi,
        scale: Scale::Each(wanted.scale),
        name: None,
    };
    assert_eq!(hand.release(Button::Primary, to[0], to[1]), [Command::SubVolume(add)]);
}

#[test]
fn a_drag_inside_of_a_box_makes_a_finer_one_and_never_more_than_eight_samples_a_voxel() {
    for (scale, finer) in [([2, 3, 4], [4, 6, 8]), ([5, 8, 1], [8, 8, 2])] {
        let mut hand = hand(Some(SubBox { lo: [4, 4, 4], hi: [60, 60, 28], scale }));
        let (from, to) = (pixel(&hand, [12.0, 20.0, 16.0]), pixel(&hand, [28.0, 30.0, 16.0]));
        hand.press(Button::Primary, from[0], from[1]);
        hand.drag(to[0], to[1]);
        let made = hand.release(Button::Primary, to[0], to[1]);
        assert!(
            matches!(made[..], [Command::SubVolume(SubVolumeCommand::Add { scale: Scale::Each(made), .. })] if made == finer),
            "{made:?}"
        );
    }
}

#[test]
fn a_face_follows_its_handle_and_says_what_the_box_becomes() {
    let mut hand = hand(Some(SubBox { lo: [10, 20, 12], hi: [30, 40, 20], scale: [2; 3] }));
    // The middle of the face at the last voxel along i.
    let (from, to) = (pixel(&hand, [30.0, 30.0, 16.0]), pixel(&hand, [37.2, 33.0, 16.0]));
    hand.press(Button::Primary, from[0], from[1]);
    hand.drag(to[0], to[1]);
    assert_eq!(note(&hand, ViewName::Axial).unwrap(), "55 × 41 × 17 samples, at most 422 kB");
    let set = SubVolumeCommand::Set {
        volume: INNER,
        lo: Some([10, 20, 12]),
        hi: Some([37, 40, 20]),
        scale: None,
        discard: false,
    };
    assert_eq!(hand.release(Button::Primary, to[0], to[1]), [Command::SubVolume(set)]);
}
