//! The fonts that annotations and labels are written in: the one that the program carries, and for what that lacks those of the system.
//!
//! The system is asked once for every character that the fonts at hand do not have. Owns what was found.

use crate::annotate::picture::error::AnnotateError;
use crate::annotate::picture::fonts::{FontBytes, Fonts};
use crate::io::{font_folders, fonts_for};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

static SHIPPED: &[u8] = include_bytes!("../../../assets/fonts/DejaVuSans.ttf");
/// Fonts of the system that one text may bring.
const MOST: usize = 8;

/// Fonts at hand.
#[derive(Default)]
pub(crate) struct FontShelf {
    fonts: Option<Arc<Fonts>>,
    found: Vec<FontBytes>,
    /// Characters that no font of the system has.
    nowhere: BTreeSet<char>,
}

impl std::fmt::Debug for FontShelf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FontShelf").field("found", &self.found.len()).finish_non_exhaustive()
    }
}

impl FontShelf {
    /// Fonts that have all characters of a text that any font here has.
    ///
    /// # Errors
    /// If a font cannot be read.
    pub(crate) fn with(&mut self, text: &str) -> Result<Arc<Fonts>, AnnotateError> {
        let fonts = match &self.fonts {
            Some(fonts) => fonts.clone(),
            None => self.anew()?,
        };
        let lacking: Vec<char> = fonts.missing(text).into_iter().filter(|c| !self.nowhere.contains(c)).collect();
        if lacking.is_empty() {
            return Ok(fonts);
        }
        for font in fonts_for(&lacking, &font_folders(), MOST) {
            // A font that cannot be read has nothing for anybody.
            let Ok(bytes) = font.bytes() else { continue };
            let name = font.path.display().to_string();
            let font = FontBytes { name, bytes: Cow::Owned(bytes), index: font.index };
            if Fonts::new(vec![font.clone()]).is_ok() {
                self.found.push(font);
            }
        }
        let fonts = self.anew()?;
        self.nowhere.extend(fonts.missing(text));
        Ok(fonts)
    }

    fn anew(&mut self) -> Result<Arc<Fonts>, AnnotateError> {
        let shipped = FontBytes { name: "DejaVu Sans".into(), bytes: Cow::Borrowed(SHIPPED), index: 0 };
        let fonts = Arc::new(Fonts::new(std::iter::once(shipped).chain(self.found.iter().cloned()).collect())?);
        self.fonts = Some(fonts.clone());
        Ok(fonts)
    }
}
