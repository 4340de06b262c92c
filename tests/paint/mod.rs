//! Brushes and strokes.
