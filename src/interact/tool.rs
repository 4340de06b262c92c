//! The tools and what they call themselves.

use crate::document::ViewName;

/// What the primary button does in a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tool {
    /// Turns the 3D view; moves the crosshair on slices.
    #[default]
    Navigate,
    /// Paints.
    Brush,
    /// Cuts the part that is hit along the sight and a screen axis.
    AxisSplit,
    /// Cuts the part that is hit parallel to the picture.
    DepthSplit,
    /// Cuts all parts that a line crosses.
    LineSplit,
    /// Moves and turns a part by hand.
    MovePart,
}

impl Tool {
    /// In the order of the tool bar.
    pub const ALL: [Self; 6] =
        [Self::Navigate, Self::Brush, Self::AxisSplit, Self::DepthSplit, Self::LineSplit, Self::MovePart];

    /// The name on its button.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Navigate => "Navigate",
            Self::Brush => "Brush",
            Self::AxisSplit => "Axis split",
            Self::DepthSplit => "Depth split",
            Self::LineSplit => "Line split",
            Self::MovePart => "Move part",
        }
    }

    /// Its key.
    pub const fn key(self) -> char {
        match self {
            Self::Navigate => 'N',
            Self::Brush => 'B',
            Self::AxisSplit => 'X',
            Self::DepthSplit => 'D',
            Self::LineSplit => 'L',
            Self::MovePart => 'M',
        }
    }

    /// One line for the status bar: what the buttons do now.
    pub const fn hint(self) -> &'static str {
        match self {
            Self::Navigate => "Drag turns the 3D view, on slices it moves the crosshair",
            Self::Brush => "Drag paints; hold E to erase; outside the object a drag turns the 3D view",
            Self::AxisSplit => "Click a part, in 3D or on a slice, to cut it along a horizontal plane; Shift: vertical",
            Self::DepthSplit => "Click a part, in 3D or on a slice, to cut it parallel to the picture",
            Self::LineSplit => "Drag a line across the parts to cut, in 3D or on a slice",
            Self::MovePart => "In the 3D view a drag moves a part and pins it; Ctrl + drag turns it",
        }
    }

    /// Whether it works on parts.
    pub const fn is_of_parts(self) -> bool {
        matches!(self, Self::AxisSplit | Self::DepthSplit | Self::LineSplit | Self::MovePart)
    }

    /// What is said if it is used where it does nothing; `None` if it does something there.
    pub fn refusal(self, view: ViewName) -> Option<&'static str> {
        (self == Self::MovePart && view != ViewName::ThreeD).then_some("Parts are moved in the 3D view")
    }
}
