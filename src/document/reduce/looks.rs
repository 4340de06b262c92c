//! What commands on colour and opacity, look, window, layers and the brush do to the scene; see `reduce`.

use crate::document::command::answers::{
    AlsoSaid, BrushSaid, FocusSaid, LayersSaid, LookSaid, SelectionLookSaid, TransferSaid, WindowSaid,
};
use crate::document::command::brush::BrushCommand;
use crate::document::command::looks::LookSetting;
use crate::document::command::views::{FocusChange, LayerChange, TransferCommand};
use crate::document::error::DocumentError;
use crate::document::reduce::place::place_in;
use crate::document::reduce::{Changed, Ground};
use crate::document::scene::check::check_transfer;
use crate::document::scene::focus::ViewFocus;
use crate::document::scene::{Layer, Scene, ViewLook, Window, first_look};
use crate::math::Plane;
use crate::paint::Mirror;
use crate::volume::{FieldKind, Lighting, Mode, VolumeId};
use std::collections::BTreeSet;

/// What of a look is given: mode, shaded, lighting, step, background.
type Given = (Option<Mode>, Option<bool>, Option<Lighting>, (Option<f64>, Option<bool>), Option<[f32; 3]>);

impl Scene {
    pub(crate) fn apply_transfer(
        &mut self,
        command: &TransferCommand,
        ground: &Ground<'_>,
    ) -> Result<Changed, DocumentError> {
        let volume = match command {
            TransferCommand::Set { volume, .. } | TransferCommand::Reset { volume } => self.meant(*volume)?,
        };
        let (name, function) = match command {
            TransferCommand::Set { function, .. } => ("Transfer function", function.clone()),
            TransferCommand::Reset { .. } => {
                // A label map beside others began with the look of its labels.
                let own = self.shown.get(&volume).is_some_and(|shown| shown.own.is_some());
                let first = match own && self.volumes.all.get(&volume).is_some_and(|settings| settings.label_map) {
                    true => first_look::of_labels(ground.grid, ground.histogram),
                    false => first_look::transfer(ground.grid, ground.histogram),
                };
                ("Reset transfer function", first)
            }
        };
        check_transfer(&function)?;
        let transfer = self.transfer_mut(volume);
        *transfer = function;
        let (lo, hi) = transfer.domain();
        let said = TransferSaid {
            colour_points: transfer.colour.len(),
            opacity_points: transfer.opacity.len(),
            domain: [lo, hi],
        };
        Ok(Changed::new(name, said))
    }

    pub(crate) fn set_look(&mut self, given: Given) -> Result<Changed, DocumentError> {
        let (mode, shaded, lighting, (step_voxels, refine), background) = given;
        let name = match (&mode, shaded, background) {
            (Some(Mode::Dvr), ..) => "Look: volume",
            (Some(Mode::Iso(_)), ..) => "Look: surface",
            (Some(Mode::Mip), ..) => "Look: maximum",
            (None, Some(true), _) => "Headlight on",
            (None, Some(false), _) => "Headlight off",
            (None, None, Some(_)) => "Background",
            _ => "Look",
        };
        if shaded == Some(false) && lighting.is_some() {
            return Err(DocumentError::invalid("lighting", "given with shaded: false", "one of the two"));
        }
        let now = self.look_of(self.volumes.active);
        let lit = lighting.or(now.lighting);
        let look = ViewLook {
            mode: mode.unwrap_or(now.mode),
            lighting: match shaded {
                Some(false) => None,
                Some(true) => lit.or_else(|| Some(Lighting::default())),
                None => lit,
            },
            step_voxels: step_voxels.unwrap_or(now.step_voxels),
            // Who names the distance of samples and no more means samples.
            refine: refine.unwrap_or(now.refine && step_voxels.is_none()),
            background: background.unwrap_or(now.background),
        };
        look.check()?;
        self.show(self.volumes.active, look);
        Ok(Changed::new(name, LookSaid { look }))
    }

    pub(crate) fn set_selection_look(
        &mut self,
        look: &LookSetting,
        volume: Option<VolumeId>,
    ) -> Result<Changed, DocumentError> {
        let of = self.meant(volume)?;
        let look = look.over(self.own_looks.selections.get(&of), self.lighting_of(of))?;
        match &look {
            Some(look) => drop(self.own_looks.selections.insert(of, look.clone())),
            None => drop(self.own_looks.selections.remove(&of)),
        }
        Ok(Changed::new("Look of the selection", SelectionLookSaid { look }))
    }

    pub(crate) fn set_window(
        &mut self,
        volume: Option<VolumeId>,
        level: f64,
        width: f64,
    ) -> Result<Changed, DocumentError> {
        let volume = self.meant(volume)?;
        let window = Window { level, width };
        window.check()?;
        // What is cut out of it is shown alike until it has a window of its own.
        let before = self.window_of(volume);
        let alike = self.cut_out_of(volume).into_iter().filter(|inner| self.window_of(*inner) == before);
        for id in alike.collect::<Vec<_>>().into_iter().chain([volume]) {
            self.show_in(id, window);
        }
        Ok(Changed::new("Window", WindowSaid { window }))
    }

    pub(crate) fn set_layer(&mut self, change: &LayerChange) -> Result<Changed, DocumentError> {
        let LayerChange { field, visible, opacity, opacity_3d, volume, shared } = *change;
        if shared && (visible.is_some() || opacity.is_some() || opacity_3d.is_some()) {
            return Err(DocumentError::invalid("shared", "true beside visible or opacity", "either one or the other"));
        }
        let id = self.meant(volume)?;
        let now = self.layer_of(id, field);
        let layer = Layer {
            field,
            visible: visible.unwrap_or(now.visible),
            opacity: opacity.unwrap_or(now.opacity),
            // Who names one strength means it everywhere.
            opacity_3d: opacity_3d.or(now.opacity_3d.filter(|_| opacity.is_none())),
        };
        layer.check()?;
        let own = volume.is_some() || self.own_layer(id, field).is_some();
        match self.shown.get_mut(&id).filter(|_| own) {
            Some(shown) => {
                shown.layers.retain(|layer| layer.field != field);
                shown.layers.extend((!shared).then_some(layer));
            }
            None if shared => {}
            None => put(&mut self.layers, layer),
        }
        let layers =
            if own { FieldKind::ALL.map(|field| self.layer_of(id, field)).to_vec() } else { self.layers.to_vec() };
        Ok(Changed::new(format!("Layer {}", field.name()), LayersSaid { layers }))
    }

    pub(crate) fn set_focus(&mut self, change: &FocusChange, ground: &Ground<'_>) -> Result<Changed, DocumentError> {
        let (FocusChange { on, distance_mm, opacity, far, at, follow }, now) = (*change, *self.focus);
        if follow && at.is_some() {
            return Err(DocumentError::invalid("follow", "true beside at", "either one or the other"));
        }
        let place = |at| place_in(at, self, ground.grid)?.ok_or_else(|| DocumentError::of_picture("at"));
        let at = at.map(place).transpose()?.map(|sample| sample.position.to_array());
        let far = far.unwrap_or(now.far);
        // What is faint when it is faded is too faint for a line.
        let usual = if far == now.far { now.opacity } else { far.usual_opacity() };
        let focus = ViewFocus {
            on: on.unwrap_or(true),
            distance_mm: distance_mm.unwrap_or(now.distance_mm),
            opacity: opacity.unwrap_or(usual),
            far,
            at: at.or(now.at.filter(|_| !follow)),
        };
        focus.check()?;
        self.focus = focus.into();
        Ok(Changed::new(if focus.on { "Focus" } else { "Focus off" }, FocusSaid { focus }))
    }

    pub(crate) fn apply_brush(&mut self, command: &BrushCommand) -> Result<Changed, DocumentError> {
        let change = match command {
            BrushCommand::Set(change) => change,
            BrushCommand::Also { volumes } => {
                self.told_apart(volumes)?;
                self.also = volumes.iter().copied().collect::<BTreeSet<_>>().into();
                let also = self.also.iter().copied().collect();
                return Ok(Changed::new("Brush", AlsoSaid { also }));
            }
        };
        if change.any_value && change.range.is_some() {
            return Err(DocumentError::invalid("any_value", "true beside a range", "either one or the other"));
        }
        if change.any_depth && change.within_mm.is_some() {
            return Err(DocumentError::invalid("any_depth", "true beside within_mm", "either one or the other"));
        }
        let mut brush = change.applied_to(&self.brush);
        if let Mirror::Face { part, face } = brush.mirror {
            brush.mirror = Mirror::Plane(self.face_plane(part, face)?);
        }
        brush.check()?;
        self.brush = brush.into();
        Ok(Changed::new("Brush", BrushSaid { brush }))
    }
}

impl Scene {
    /// The plane at rest of a part's face.
    fn face_plane(&self, part: u32, face: usize) -> Result<Plane, DocumentError> {
        let parts = &self.explosion.parts;
        let found = parts.iter().find(|p| p.id.0 == part).ok_or_else(|| {
            let known: Vec<_> = parts.iter().map(|p| p.id.to_string()).collect();
            DocumentError::invalid("mirror.face.part", part, format!("a part: {}", known.join(", ")))
        })?;
        let expected = format!("a face of it, 0 to {}", found.faces.len().saturating_sub(1));
        let plane = found.faces.get(face).map(|f| f.plane);
        plane.ok_or_else(|| DocumentError::invalid("mirror.face.face", face, expected))
    }
}

/// Adds a layer, or replaces that of its field.
fn put(layers: &mut Vec<Layer>, layer: Layer) {
    match layers.iter_mut().find(|l| l.field == layer.field) {
        Some(known) => *known = layer,
        None => layers.push(layer),
    }
}
