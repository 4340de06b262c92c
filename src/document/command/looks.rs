//! What commands say of the look that a thing has for itself; see `command`.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::error::DocumentError;
use crate::document::scene::own_looks::{LookChange, said};
use crate::document::scene::volumes::OwnLook;
use crate::volume::{Lighting, Mode, TransferFunction};
use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// A look for itself, or `"inherit"`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum LookSetting {
    /// None: it is shown as what it belongs to.
    Inherit(Inherit),
    /// What is given changes and the rest stays as it is.
    Own(Box<LookFields>),
}

/// The word for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Inherit {
    /// `"inherit"`.
    Inherit,
}

/// What of a look is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LookFields {
    /// Colour and opacity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferFunction>,
    /// How rays become colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<Mode>,
    /// `false`: unshaded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shaded: Option<bool>,
    /// `null`: unshaded, too.
    #[serde(default, deserialize_with = "said", skip_serializing_if = "Option::is_none")]
    pub lighting: Option<Option<Lighting>>,
    /// 0 to 1: multiplies what is inherited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f32>,
}

// By hand, so that a wrong field of a look is named instead of "no variant".
impl<'de> Deserialize<'de> for LookSetting {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = LookSetting;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("\"inherit\" or a look with transfer, mode, shaded, lighting, opacity")
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<LookSetting, E> {
                Inherit::deserialize(StrDeserializer::new(word)).map(LookSetting::Inherit)
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<LookSetting, M::Error> {
                let fields = LookFields::deserialize(MapAccessDeserializer::new(map))?;
                Ok(LookSetting::Own(Box::new(fields)))
            }
        }
        from.deserialize_any(Either)
    }
}

impl LookFields {
    /// The light that follows from what is given over the one so far; `None`: as so far.
    fn light(&self, so_far: Option<Lighting>) -> Result<Option<Option<Lighting>>, DocumentError> {
        match (self.shaded, self.lighting) {
            (Some(false), Some(Some(_))) => {
                Err(DocumentError::invalid("look.lighting", "given with shaded: false", "one of the two"))
            }
            (Some(true), Some(None)) => {
                Err(DocumentError::invalid("look.lighting", "null with shaded: true", "one of the two"))
            }
            (Some(false), _) => Ok(Some(None)),
            (Some(true), None) => Ok(Some(Some(so_far.unwrap_or_default()))),
            (_, given) => Ok(given),
        }
    }
}

impl LookSetting {
    /// The change that follows from this over the one so far; `None`: all is inherited from now on. `lit` is the light that is seen.
    ///
    /// # Errors
    /// If it is none that can be drawn.
    pub(crate) fn over(
        &self,
        so_far: Option<&LookChange>,
        lit: Option<Lighting>,
    ) -> Result<Option<LookChange>, DocumentError> {
        let Self::Own(given) = self else { return Ok(None) };
        let mut look = so_far.cloned().unwrap_or_default();
        look.lighting = given.light(look.lighting.unwrap_or(lit))?.or(look.lighting);
        look.mode = given.mode.or(look.mode);
        look.opacity = given.opacity.unwrap_or(look.opacity);
        if let Some(transfer) = &given.transfer {
            look.transfer = Some(transfer.clone());
        }
        look.check().map_err(|error| error.within("look"))?;
        Ok(Some(look))
    }

    /// The look of a volume that follows from this over the one that it is shown with, and its opacity if that is given. `None`: it is
    /// shown as the document is.
    ///
    /// # Errors
    /// If it is none that can be drawn.
    pub(crate) fn of_volume(&self, so_far: OwnLook) -> Result<(Option<OwnLook>, Option<f32>), DocumentError> {
        let Self::Own(given) = self else { return Ok((None, None)) };
        let LookFields { transfer, mode, opacity, .. } = &**given;
        let look = OwnLook {
            transfer: transfer.clone().unwrap_or(so_far.transfer),
            mode: mode.unwrap_or(so_far.mode),
            lighting: given.light(so_far.lighting)?.unwrap_or(so_far.lighting),
        };
        look.check().map_err(|error| error.within("look"))?;
        Ok((Some(look), *opacity))
    }
}
