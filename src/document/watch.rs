//! Who is told how far a long command has got, and may stop it.

use std::sync::Arc;

/// Gets the share done, 0..1, from whichever thread works, and answers whether to go on. The default goes on.
#[derive(Clone)]
pub struct Watch(Arc<dyn Fn(f32) -> bool + Send + Sync>);

impl Watch {
    /// Told by calling `told`.
    pub fn new(told: impl Fn(f32) -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(told))
    }

    /// Tells the share done; answers whether to go on.
    pub(super) fn proceed(&self, share: f32) -> bool {
        (self.0)(share)
    }
}

impl Default for Watch {
    fn default() -> Self {
        Self::new(|_| true)
    }
}

impl std::fmt::Debug for Watch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Watch")
    }
}
