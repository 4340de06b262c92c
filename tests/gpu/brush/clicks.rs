//! A stroke's first dabs, of which no coverage is gathered, and what follows them: no trace of how it was done.

use super::*;
use crate::common::gpu::{Sampled, sample};

/// Every target and form of density, in place and apart.
fn canvases(gpu: &Gpu) -> Vec<(Target, Canvas)> {
    let density = Target::Density(30_000.0);
    let fields = [Target::Selection(0.7), Target::Label(300), Target::Colour([0.2, 0.9, 0.5, 0.8]), density];
    let mut all: Vec<_> = fields.map(|target| (target, Canvas::codes(gpu, grids()[1]))).into();
    all.push((Target::Density(77.0), Canvas::floats(gpu, grids()[1])));
    let mut apart = Canvas::codes(gpu, grids()[2]);
    apart.lay(gpu, true);
    all.push((density, apart));
    all
}

/// Dabs about the corner of eight bricks and out of the volume.
fn dabs(grid: &Grid) -> Vec<Dab> {
    let at = |i: usize| DVec3::new(22.0 + 4.0 * i as f64, 30.0 + 0.7 * i as f64, 28.0 + 1.1 * i as f64);
    (0..7).map(|i| Dab { pressure: 1.0 - 0.1 * i as f32, ..dab_at(grid, at(i), 6.0) }).collect()
}

#[test]
fn a_stroke_that_goes_on_after_its_first_dabs_is_that_of_one_frame() {
    let Some(gpu) = gpu() else { return };
    for (target, mut canvas) in canvases(&gpu) {
        // What is added to these densities has no room in their codes.
        let sum = if target.field() == FieldKind::Density { Operation::Restore } else { Operation::Add };
        for (tip, operation) in [(Tip::Wash, Operation::Replace), (Tip::BuildUp, Operation::Blend), (Tip::BuildUp, sum)]
        {
            let brush = Brush { target, tip, operation, strength: 0.6, radius_mm: 6.0, ..Brush::default() };
            let dabs = dabs(&canvas.grid);
            let mut results = Vec::new();
            for frames in [&[7][..], &[1, 6], &[3, 1, 3], &[1, 1, 1, 4]] {
                canvas.begin(&brush);
                let mut laid = 0;
                for count in frames {
                    canvas.extend(&dabs[laid..laid + count]);
                    laid += count;
                }
                results.push(canvas.finish());
                let field = canvas.field(target.field()).clone();
                let refresh =
                    Refresh::whole(field.brick_indices(0).into_iter().map(|index| BrickKey { level: 0, index }));
                canvas.pools.refresh(&gpu, target.field(), &field, &refresh).unwrap();
            }
            // Where nothing was painted before, taking density's paint away changes nothing.
            assert!(results[0].len() > 3 || operation == Operation::Restore, "{target:?}");
            assert!(results.iter().all(|r| *r == results[0]), "{target:?} {tip:?}");
        }
    }
}

#[test]
fn what_a_click_leaves_is_taken_back_and_looked_behind_as_a_strokes() {
    let Some(gpu) = gpu() else { return };
    for (target, mut canvas) in canvases(&gpu) {
        let kind = target.field();
        let brush = Brush { target, radius_mm: 6.0, ..Brush::default() };
        let dabs = dabs(&canvas.grid);
        let at: Vec<[f32; 3]> = (0..40).map(|i| [i as f32, 31.0, 29.0 + i as f32 * 0.1]).collect();
        let frame = frame(&canvas.grid, ramp(-100.0, 70_000.0), DVec3::NEG_Y, [16, 16]);
        let sampled = |pools: &FieldPools| -> Vec<_> {
            let bits = |s: Sampled| (s.density.to_bits(), s.selection.to_bits(), s.label, s.colour.map(f32::to_bits));
            sample(&gpu, pools, &at).into_iter().map(bits).collect()
        };
        let seen = |canvas: &mut Canvas| {
            let Canvas { grid, density, colour, selection, labels, pools, .. } = canvas;
            let fields = one_volume(grid, density, colour, selection, labels);
            pools.make_resident(&gpu, &fields, &frame).unwrap();
            sampled(pools)
        };
        let before = seen(&mut canvas);
        for frames in [1, 2] {
            canvas.begin(&brush);
            (0..frames).for_each(|i| drop(canvas.extend(&dabs[i * 3..i * 3 + 3])));
            let painted = seen(&mut canvas);
            assert!(painted != before, "{kind:?}");
            // Behind the stroke lies what was there before it, and then it shows again.
            let Canvas { painter, pools, grid, density, colour, selection, labels, .. } = &mut canvas;
            let behind = painter.at_start(pools, |_, _| true, |pools| Ok(sampled(pools))).unwrap();
            // What a picture shows, and where, hangs on these two alone: others are not put back.
            if matches!(kind, FieldKind::Density | FieldKind::Selection) {
                assert!(behind == before, "{kind:?}");
            }
            let fields = one_volume(grid, density, colour, selection, labels);
            let refresh = of_one(painter.cancel(pools).unwrap());
            pools.refresh_painted(&gpu, kind, fields.field(kind.into()).unwrap(), &refresh).unwrap();
            assert!(seen(&mut canvas) == before, "{kind:?} after {frames}");
        }
    }
}
