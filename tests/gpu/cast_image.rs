//! Pictures in files.

use burin::gpu::{Image, ImageError};

fn sample() -> Image {
    let mut image = Image::empty([3, 2]);
    image.colour[0] = [0.5, 0.25, 0.0, 0.5];
    image.colour[4] = [1.0, 0.2, 0.03, 1.0];
    image.depth_mm[4] = 123.25;
    image.object[4] = burin::gpu::ObjectId::new(burin::volume::VolumeId(2), 6, true, 9);
    image
}

#[test]
fn a_png_holds_straight_colour_or_the_background() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    sample().write(&path, None).unwrap();
    let read = image::open(&path).unwrap().to_rgba8();
    assert_eq!(read.dimensions(), (3, 2));
    assert_eq!(read.get_pixel(0, 0).0, [255, 128, 0, 128]);
    assert_eq!(read.get_pixel(1, 0).0, [0; 4]);
    assert_eq!(read.get_pixel(1, 1).0, [255, 51, 8, 255]);
    sample().write(&path, Some([0.0, 1.0, 0.0])).unwrap();
    let read = image::open(&path).unwrap().to_rgba8();
    assert_eq!(read.get_pixel(0, 0).0, [128, 191, 0, 255]);
    assert_eq!(read.get_pixel(1, 0).0, [0, 255, 0, 255]);
}

#[test]
fn an_exr_holds_linear_colour_depth_and_object() {
    use exr::prelude::*;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    sample().write(&path, None).unwrap();
    let read = read_first_flat_layer_from_file(&path).unwrap().layer_data;
    assert_eq!(read.size, Vec2(3, 2));
    let channel = |name: &str| {
        let found = read.channel_data.list.iter().find(|c| c.name.to_string() == name);
        found.unwrap_or_else(|| panic!("no channel {name}")).sample_data.clone()
    };
    let float = |name: &str| channel(name).values_as_f32().collect::<Vec<f32>>();
    let z = float("Z");
    assert_eq!(z[4], 123.25);
    assert!(z.iter().enumerate().all(|(i, z)| i == 4 || *z == f32::INFINITY));
    for (name, number) in [("id", 7), ("volume", 3), ("segment", 9), ("selected", 1)] {
        assert_eq!(channel(name), FlatSamples::U32(vec![0, 0, 0, 0, number, 0]), "{name}");
    }
    assert_eq!(float("A")[0], 0.5);
    // sRGB's curve at 1, ½ and 0.2 (IEC 61966-2-1), of the colour without its alpha.
    assert!((float("R")[0] - 0.5).abs() < 1e-6);
    assert!((float("G")[0] - 0.5 * 0.214_041).abs() < 1e-5);
    assert!((float("G")[4] - 0.033_105).abs() < 1e-5);
    assert!((float("B")[4] - 0.03 / 12.92).abs() < 1e-6);
}

#[test]
fn a_pixel_made_of_itself_alone_is_left_as_it_is() {
    let mut image = sample();
    // A highlight is whiter than white until it is averaged.
    image.colour[2] = [1.5, 1.25, 1.0, 1.0];
    assert_eq!(image.clone().averaged(1), image);
    assert_eq!(image.clone().averaged(0), image);
    let mut large = Image::empty([2, 2]);
    large.colour = vec![[1.5, 0.5, 0.25, 1.0]; 4];
    assert_eq!(large.averaged(2).colour, [[1.0, 0.5, 0.25, 1.0]]);
}

#[test]
fn a_file_that_cannot_be_written_is_named() {
    let error = sample().write(std::path::Path::new("/nowhere/at/all.png"), None).unwrap_err();
    assert!(error.to_string().contains("/nowhere/at/all.png"), "{error}");
    assert!(matches!(sample().write(std::path::Path::new("a.gif"), None), Err(ImageError::UnknownFormat { .. })));
    let dir = tempfile::tempdir().unwrap();
    for name in ["a.png", "a.exr"] {
        let taken = dir.path().join(name);
        std::fs::create_dir(&taken).unwrap();
        sample().write(&taken, None).unwrap_err();
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 2, "nothing is left beside");
}

#[test]
fn an_object_says_what_it_was_made_of_to_the_ends_of_each_number() {
    use burin::gpu::ObjectId;
    use burin::volume::VolumeId;
    assert_eq!((ObjectId::NOTHING.body(), ObjectId::NOTHING.volume(), ObjectId::NOTHING.segment()), (None, None, None));
    for (volume, body, selected, segment) in
        [(0, 0, false, 0), (1, 2, true, 3), ((1 << 18) - 1, (1 << 28) - 1, true, u16::MAX), (70_000, 1 << 27, false, 1)]
    {
        let object = ObjectId::new(VolumeId(volume), body, selected, segment);
        assert_ne!(object, ObjectId::NOTHING);
        assert_eq!((object.volume(), object.body()), (Some(VolumeId(volume)), Some(body)));
        assert_eq!((object.is_selected(), object.segment()), (selected, (segment != 0).then_some(segment)));
    }
}
