//! What the parts of a scene may hold: one check for each, for commands and for what is read from disk.
//!
//! A command that fails its check is refused. A part that was kept and fails it is put right, or becomes what it is in a volume that
//! was just opened, and that is told: nothing behind the scene meets a number that it cannot use. Knows no files.

use crate::document::error::DocumentError;
use crate::document::scene::volumes::{OwnLook, VolumeLook, VolumeSettings};
use crate::document::scene::{Layer, Origin, Scene, ViewLook, Views, Window};
use crate::explode::Explosion;
use crate::math::{Aabb, Camera, DVec3, Pose, Projection};
use crate::volume::{FieldKind, Lighting, Mode, Segment, Segments, TransferFunction, Volume, VolumeId};
use std::collections::{BTreeMap, BTreeSet};

/// Ids of parts count up; no hand gets near this.
const MOST_PARTS_EVER: u32 = 1 << 30;
/// Further from where its file puts it a volume lies in no world of numbers that tell its voxels apart.
const FARTHEST_MM: f64 = 1e9;

impl ViewLook {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        if let Mode::Iso(value) = self.mode {
            finite("mode.iso", value)?;
        }
        if let Some(light) = self.lighting {
            let Lighting { ambient, diffuse, specular, power } = light;
            if [ambient, diffuse, specular, power].iter().any(|t| !(t.is_finite() && *t >= 0.0)) {
                return Err(DocumentError::invalid("lighting", format!("{light:?}"), "numbers from 0 up"));
            }
        }
        if !(0.05..=16.0).contains(&self.step_voxels) {
            return Err(DocumentError::invalid("step_voxels", self.step_voxels, "0.05 to 16 voxels"));
        }
        checked_colour("background", self.background).map(drop)
    }
}

impl Window {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        finite("level", self.level)?;
        positive("width", self.width).map(drop)
    }
}

impl Layer {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        for (name, opacity) in [("opacity", Some(self.opacity)), ("opacity_3d", self.opacity_3d)] {
            let Some(opacity) = opacity else { continue };
            if !(0.0..=1.0).contains(&opacity) {
                return Err(DocumentError::invalid(name, opacity, "0 to 1"));
            }
            if self.field == FieldKind::Density && opacity != 1.0 {
                let expected = "1: density's own look is the grey window in slices and the transfer function in 3D";
                return Err(DocumentError::invalid(name, opacity, expected));
            }
        }
        Ok(())
    }
}

impl Views {
    /// # Errors
    /// The first field that is wrong.
    fn check(&self, bounds: &Aabb) -> Result<(), DocumentError> {
        safe_camera(self.camera, bounds)?;
        near("crosshair", self.crosshair, bounds)?;
        for slice in &self.slices {
            positive("slices.height_mm", slice.height_mm)?;
            near("slices.centre", slice.centre, bounds)?;
            check_size(slice.size)?;
        }
        check_size(self.size).map(drop)
    }
}

/// # Errors
/// The first field that is wrong.
pub(crate) fn check_segment(segment: &Segment) -> Result<(), DocumentError> {
    if segment.id == 0 {
        return Err(DocumentError::invalid("id", 0, "1 to 65535; label 0 is unlabelled matter"));
    }
    checked_colour("colour", segment.colour).map(drop)
}

fn check_segments(segments: &Segments) -> Result<(), DocumentError> {
    let at = |i: usize, e: DocumentError| e.within(&format!("segments[{i}]"));
    segments.0.iter().enumerate().try_for_each(|(i, s)| check_segment(s).map_err(|e| at(i, e)))?;
    match segments.0.windows(2).position(|pair| pair[0].id >= pair[1].id) {
        Some(i) => {
            let found = format!("{} after {}", segments.0[i + 1].id, segments.0[i].id);
            Err(DocumentError::invalid("segments", found, "ids that rise"))
        }
        None => Ok(()),
    }
}

fn check_layers(layers: &[Layer]) -> Result<(), DocumentError> {
    for (i, layer) in layers.iter().enumerate() {
        layer.check().map_err(|e| e.within(&format!("layers[{i}]")))?;
        if layers[..i].iter().any(|other| other.field == layer.field) {
            return Err(DocumentError::invalid(format!("layers[{i}]"), layer.field.name(), "each field once"));
        }
    }
    Ok(())
}

fn check_explosion(explosion: &Explosion, bounds: &Aabb) -> Result<(), DocumentError> {
    if explosion.next_id > MOST_PARTS_EVER {
        let expected = format!("at most {MOST_PARTS_EVER}");
        return Err(DocumentError::invalid("explosion.next_id", explosion.next_id, expected));
    }
    explosion.check()?;
    // Parts stay where they were made, wherever volumes are moved to and whichever of them goes.
    let reach = 1.001 * bounds.min.abs().max(bounds.max.abs()).max_element().max(2.0 * FARTHEST_MM);
    let out = |v: &DVec3| v.abs().max_element() > reach;
    for (i, part) in explosion.parts.iter().enumerate() {
        if let Some(corner) = part.vertices.iter().find(|v| out(v)) {
            let found = format!("a corner at {corner}");
            return Err(DocumentError::invalid(
                format!("parts[{i}].vertices"),
                found,
                format!("corners of at most {reach:e} mm"),
            ));
        }
    }
    Ok(())
}

pub(crate) fn check_transfer(transfer: &TransferFunction) -> Result<(), DocumentError> {
    transfer.check().map_err(|found| DocumentError::NotNow(format!("transfer function: {found}")))
}

impl VolumeSettings {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        if !(0.0..=1.0).contains(&self.opacity) {
            return Err(DocumentError::invalid("opacity", self.opacity, "0 to 1"));
        }
        check_pose(&self.pose)?;
        check_segments(&self.segments)
    }
}

impl VolumeLook {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        self.window.check().map_err(|e| e.within("window"))?;
        check_layers(&self.layers)?;
        self.own.as_ref().map_or(Ok(()), |own| own.check().map_err(|e| e.within("look")))
    }
}

impl OwnLook {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        check_transfer(&self.transfer)?;
        ViewLook { mode: self.mode, lighting: self.lighting, ..ViewLook::default() }.check()
    }
}

/// A volume's own pose: a turn and a shift that numbers can hold.
pub(crate) fn check_pose(pose: &Pose) -> Result<(), DocumentError> {
    let length = pose.rotation.length();
    if !(length.is_finite() && (length - 1.0).abs() < 1e-3) {
        let found = format!("{:?}", pose.rotation.to_array());
        return Err(DocumentError::invalid("pose.rotation", found, "a quaternion of length 1: x, y, z, w"));
    }
    if !(pose.translation.is_finite() && pose.translation.abs().max_element() <= FARTHEST_MM) {
        let (found, expected) = (pose.translation, format!("three numbers of at most {FARTHEST_MM:e} mm"));
        return Err(DocumentError::invalid("pose.translation", found, expected));
    }
    Ok(())
}

/// What of a volume is said where something is wrong: of the first alone its field, as before there were others.
fn of_volume(id: VolumeId) -> impl Fn(DocumentError) -> DocumentError {
    move |error| if id == VolumeId::FIRST { error } else { error.within(&format!("volumes.{id}")) }
}

impl Scene {
    /// Checks all parts; `bounds` is the box of all volumes, world mm.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, bounds: &Aabb) -> Result<(), DocumentError> {
        check_transfer(&self.transfer)?;
        self.views.check(bounds).map_err(|e| e.within("views"))?;
        self.look.check().map_err(|e| e.within("look"))?;
        check_layers(&self.layers)?;
        self.focus.check().map_err(|e| e.within("focus"))?;
        self.shown.iter().try_for_each(|(id, shown)| shown.check().map_err(of_volume(*id)))?;
        self.volumes.all.iter().try_for_each(|(id, volume)| volume.check().map_err(of_volume(*id)))?;
        self.own_looks.check().map_err(|e| e.within("own_looks"))?;
        self.annotations.check().map_err(|e| e.within("annotations"))?;
        self.labels.check().map_err(|e| e.within("labels"))?;
        self.cutaways.check().map_err(|e| e.within("cutaways"))?;
        self.brush.check()?;
        check_explosion(&self.explosion, bounds)
    }

    /// Puts right what was kept and cannot be used; answers what was wrong, in sentences.
    pub(crate) fn mend(&mut self, volumes: &BTreeMap<VolumeId, Volume>, bounds: &Aabb) -> Vec<String> {
        let mut told = Vec::new();
        let known: BTreeSet<VolumeId> = volumes.keys().copied().filter(|id| !id.is_of_before()).collect();
        self.shown.retain(|id, _| known.contains(id));
        if self.volumes.all.keys().any(|id| !known.contains(id)) {
            told.push("volumes that the project does not hold are gone from the list".to_owned());
            self.volumes.all.retain(|id, _| known.contains(id));
        }
        for (id, volume) in volumes.iter().filter(|(id, _)| known.contains(id)) {
            let window = Window::from_histogram(&volume.histogram);
            self.shown.entry(*id).or_insert(VolumeLook::new(window));
        }
        if !known.contains(&self.volumes.active) {
            self.volumes.active = known.first().copied().unwrap_or_default();
        }
        self.volumes.next = self.volumes.next.max(known.last().map_or(0, |last| last.0.saturating_add(1)));
        self.keep_own_looks();
        if self.check(bounds).is_ok() {
            return told;
        }
        let fresh = volumes.values().next().map_or_else(Self::empty, |volume| {
            Self::new(volume.grid(), &volume.histogram, VolumeSettings::new("", Origin::nowhere()))
        });
        let mut tell = |checked: Result<(), DocumentError>, now: &str| match checked {
            Ok(()) => false,
            Err(error) => {
                told.push(format!("{error}; {now}"));
                true
            }
        };
        if tell(check_transfer(&self.transfer), "the transfer function was made anew from the histogram") {
            self.transfer = fresh.transfer;
        }
        if tell(self.views.check(bounds).map_err(|e| e.within("views")), "all views show the whole volume") {
            self.views = fresh.views;
        }
        for (id, shown) in self.shown.iter_mut() {
            let window = shown.window.check().map_err(|e| of_volume(*id)(e.within("window")));
            if let (true, Some(volume)) = (tell(window, "the window was made anew from the histogram"), volumes.get(id))
            {
                shown.window = Window::from_histogram(&volume.histogram);
            }
            let own = shown.own.as_ref().map_or(Ok(()), |own| own.check().map_err(of_volume(*id)));
            if tell(own, "the volume is shown as the document is") {
                shown.own = None;
            }
        }
        if tell(self.look.check().map_err(|e| e.within("look")), "the look is that of a new document") {
            self.look = fresh.look;
        }
        if tell(check_layers(&self.layers), "layers are shown as in a new document") {
            self.layers = fresh.layers;
        }
        if tell(self.focus.check().map_err(|e| e.within("focus")), "the 3D view has no focus") {
            self.focus = fresh.focus;
        }
        for (id, volume) in &mut self.volumes.all {
            let checked = check_segments(&volume.segments).map_err(of_volume(*id));
            if tell(checked, "segments were put in order, their colours in range") {
                volume.segments = put_in_order(std::mem::take(&mut volume.segments));
            }
            if tell(volume.check().map_err(of_volume(*id)), "the volume lies and shows as in its file") {
                (volume.opacity, volume.pose) = (1.0, Pose::IDENTITY);
            }
        }
        let own = self.own_looks.check().map_err(|e| e.within("own_looks"));
        if tell(own, "parts, selections and segments are shown as their volumes are") {
            self.own_looks = fresh.own_looks;
        }
        if tell(
            self.annotations.check().map_err(|e| e.within("annotations")),
            "annotations that cannot be used are gone",
        ) {
            self.annotations.all.retain(|_, one| one.check().is_ok());
            self.annotations.next = self.annotations.all.keys().last().map_or(0, |last| last.0.saturating_add(1));
            if self.annotations.check().is_err() {
                self.annotations = fresh.annotations;
            }
        }
        if tell(self.labels.check().map_err(|e| e.within("labels")), "labels that cannot be used are gone") {
            self.labels.all.retain(|_, one| one.check().is_ok());
            self.labels.next = self.labels.all.keys().last().map_or(0, |last| last.0.saturating_add(1));
            if self.labels.check().is_err() {
                self.labels = fresh.labels;
            }
        }
        if tell(self.cutaways.check().map_err(|e| e.within("cutaways")), "cutaways that cannot be used are gone") {
            self.cutaways.all.retain(|_, one| one.check().is_ok());
            self.cutaways.next = self.cutaways.all.keys().last().map_or(0, |last| last.0.saturating_add(1));
            if self.cutaways.check().is_err() {
                self.cutaways = fresh.cutaways;
            }
        }
        if tell(self.brush.check().map_err(DocumentError::from), "the brush is that of a new document") {
            self.brush = fresh.brush;
        }
        if tell(check_explosion(&self.explosion, bounds), "the volume is one part again") {
            self.explosion = fresh.explosion;
        }
        told
    }
}

/// The same segments by rising id; of two with one id the first, of a colour that is none the id's own.
fn put_in_order(segments: Segments) -> Segments {
    let mut ordered = Segments::default();
    for mut segment in segments.0 {
        if checked_colour("colour", segment.colour).is_err() {
            segment.colour = Segment::new(segment.id).colour;
        }
        if segment.id > 0 && ordered.get(segment.id).is_none() {
            ordered.put(segment);
        }
    }
    ordered
}

/// Diagonals of the volume from its centre within which there is something to see: further out, samples along a ray can no
/// longer be told apart.
const REACH: f64 = 1e4;

/// A point that is not lost in space.
pub(crate) fn near(field: &str, point: DVec3, bounds: &Aabb) -> Result<DVec3, DocumentError> {
    let reach = REACH * 2.0 * bounds.half_diagonal();
    let away = point.distance(bounds.centre());
    // Whoever is as far from zero as numbers go has no distance.
    if away <= reach {
        return Ok(point);
    }
    Err(DocumentError::invalid(field, format!("a point {away:e} mm from the volume"), format!("at most {reach:e} mm")))
}

/// A camera that sees something.
pub(crate) fn safe_camera(camera: Camera, bounds: &Aabb) -> Result<Camera, DocumentError> {
    let invalid = |field: &str, found: String, expected: &str| Err(DocumentError::invalid(field, found, expected));
    for (name, v) in [("camera.eye", camera.eye), ("camera.target", camera.target), ("camera.up", camera.up)] {
        if !v.is_finite() {
            return invalid(name, format!("{v}"), "three finite numbers");
        }
    }
    near("camera.eye", camera.eye, bounds)?;
    near("camera.target", camera.target, bounds)?;
    if camera.eye == camera.target {
        return invalid("camera.target", format!("{} as the eye", camera.target), "another point than the eye");
    }
    match camera.projection {
        Projection::Perspective { fov_y_deg } if !(fov_y_deg > 0.0 && fov_y_deg < 180.0) => {
            invalid("camera.projection.fov_y_deg", fov_y_deg.to_string(), "between 0 and 180 degrees")
        }
        Projection::Orthographic { height_mm } if !(height_mm.is_finite() && height_mm > 0.0) => {
            invalid("camera.projection.height_mm", height_mm.to_string(), "a positive length")
        }
        _ => Ok(camera),
    }
}

pub(crate) fn checked_colour(field: &str, colour: [f32; 3]) -> Result<[f32; 3], DocumentError> {
    if colour.iter().all(|c| (0.0..=1.0).contains(c)) {
        Ok(colour)
    } else {
        Err(DocumentError::invalid(field, format!("{colour:?}"), "red, green and blue of 0 to 1"))
    }
}

pub(crate) fn finite(field: &str, value: f64) -> Result<f64, DocumentError> {
    if value.is_finite() { Ok(value) } else { Err(DocumentError::invalid(field, value, "a finite number")) }
}

pub(crate) fn positive(field: &str, value: f64) -> Result<f64, DocumentError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(DocumentError::invalid(field, value, "a positive number"))
    }
}

pub(crate) fn direction(field: &str, v: [f64; 3]) -> Result<DVec3, DocumentError> {
    DVec3::from_array(v)
        .try_normalize()
        .ok_or_else(|| DocumentError::invalid(field, format!("{v:?}"), "a direction other than zero"))
}

/// Most pixels of a picture: with depth and object each takes 24 bytes on the host alone.
const MAX_PIXELS: u64 = 1 << 26;

/// A picture's size that can be drawn.
pub(crate) fn check_size(size: [u32; 2]) -> Result<[u32; 2], DocumentError> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if size.iter().all(|s| (1..=16_384).contains(s)) && pixels <= MAX_PIXELS {
        Ok(size)
    } else {
        let expected = "1 to 16384 pixels either way, 67108864 in all";
        Err(DocumentError::invalid("size", format!("{size:?}"), expected))
    }
}
