//! Grids with as little distortion as the surface allows, and no folds.
//!
//! The open problem of "Direct Volume Editing", section 5: the paper's grid, traced from a spine, stretches and folds where the
//! surface curves. Here the lattice grows from the picked point and slides on the surface until it is its own patch's flat image of
//! least symmetric Dirichlet energy (free boundary). Owns the order of these; the moves are the sheet's.

use crate::annotate::grid::SurfaceGrid;
use crate::annotate::relaxing::dirichlet::Factor;
use crate::annotate::relaxing::growth::grown;
use crate::annotate::relaxing::sheet::Sheet;
use crate::annotate::surface::Surface;
use glam::DVec3;

/// The most rounds of sliding at full size.
const MOST_ROUNDS: usize = 8;

/// A lattice is at rest when no vertex would go farther than this, in spacings.
const NEAR: f64 = 0.02;

/// A round that lessens the excess by no more than this share gains nothing.
const ENOUGH: f64 = 0.01;

/// The relaxed grid of `columns` × `rows` vertices (rounded up to odd), `spacing_mm` apart, about the point of the surface at
/// `centre` (world mm; itself traced back to the surface first), its u axis there along `orientation` (world axes, any length).
///
/// No triangle is turned over; where the surface ends or tears the grid is trimmed. It is never of more energy than `plain`, a grid
/// of the same size about the same centre, if that has no fold and is trimmed no more. All is trimmed if the surface cannot be
/// found at the centre, if `orientation` is along its normal, or once `cancel` answers true.
pub fn relax<S: Surface + ?Sized>(
    surface: &S,
    centre: DVec3,
    orientation: DVec3,
    columns: usize,
    rows: usize,
    spacing_mm: f64,
    plain: Option<&SurfaceGrid>,
    cancel: &dyn Fn() -> bool,
) -> SurfaceGrid {
    let half = [columns / 2, rows / 2];
    let [columns, rows] = half.map(|half| 2 * half + 1);
    let nothing = || SurfaceGrid { columns, rows, spacing_mm, points: vec![None; columns * rows] };
    let Some(seed) = Sheet::of_centre(surface, centre, orientation, spacing_mm) else { return nothing() };
    let mut factor = Factor::default();
    let Some(sheet) = grown(seed.clone(), half, &mut factor, cancel) else { return nothing() };
    let mut best = settled(sheet, &mut factor, cancel);
    // One that is trimmed more has less to bend around.
    let fit = |plain: &&SurfaceGrid| {
        (plain.columns, plain.rows) == (columns, rows)
            && plain.trimmed() <= best.trimmed()
            && plain.turned_over(surface) == 0
    };
    if let Some(plain) = plain.filter(fit) {
        let excess = plain.distortion().excess;
        if excess < best.distortion().excess {
            factor.holds = false;
            for other in [settled(seed.of_grid(plain), &mut factor, cancel), plain.clone()] {
                if other.distortion().excess < best.distortion().excess {
                    best = other;
                }
            }
        }
    }
    if cancel() { nothing() } else { best }
}

/// Slides the sheet until it rests; the round of least energy without a fold.
fn settled<S: Surface + ?Sized>(
    mut sheet: Sheet<'_, S>,
    factor: &mut Factor,
    cancel: &dyn Fn() -> bool,
) -> SurfaceGrid {
    let mut best = (sheet.unfold(40) == 0).then(|| (sheet.grid().distortion().excess, sheet.clone()));
    let (mut before, mut share, mut idle) = (f64::INFINITY, 1.0, false);
    for _ in 0..MOST_ROUNDS {
        if cancel() {
            break;
        }
        let far = sheet.slide(3, share, factor);
        let left = sheet.unfold(40);
        let excess = sheet.grid().distortion().excess;
        let least = best.as_ref().map_or(f64::INFINITY, |(least, _)| *least);
        if left == 0 && excess < least {
            best = Some((excess, sheet.clone()));
        }
        // Far from rest, one round without gain may be followed by one with.
        let gains = excess < least * (1.0 - ENOUGH) || left > 0;
        if left == 0 && (far < NEAR || !gains && (idle || far < 10.0 * NEAR)) {
            break;
        }
        idle = !gains;
        if far > 0.7 * before {
            share = 0.5;
        }
        before = far;
    }
    let mut sheet = best.map_or(sheet, |(_, sheet)| sheet);
    sheet.trim_folds();
    sheet.grid()
}
