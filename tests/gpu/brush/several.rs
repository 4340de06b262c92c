//! A stroke on two volumes: what one of them has no room for, none gets; a device that is lost is painted anew with both.

use super::*;
use burin::gpu::{Fields, VolumeFields};

/// Two volumes that share the pools: the first of few bricks, the second of many.
struct Two {
    canvases: [Canvas; 2],
    pools: FieldPools,
    painter: Painter,
}

const IDS: [VolumeId; 2] = [VolumeId(0), VolumeId(1)];

fn fields(canvases: &[Canvas; 2]) -> Fields<'_> {
    let mut fields = Fields::default();
    for (id, canvas) in IDS.into_iter().zip(canvases) {
        let Canvas { grid, density, colour, selection, labels, .. } = canvas;
        fields.put(id, VolumeFields { grid: *grid, density, colour, selection, labels });
    }
    fields
}

impl Two {
    fn new(gpu: &Gpu) -> Self {
        let canvas = |dims| {
            let grid = Grid::aligned(dims, DVec3::ONE, DVec3::ZERO);
            Canvas::new(gpu, grid, density_u16(grid, |v| noise(v, 0) as u16 / 2))
        };
        let canvases = [canvas([70, 40, 8]), canvas([196, 196, 8])];
        Self { canvases, pools: FieldPools::empty(gpu, 64 << 20).unwrap(), painter: Painter::new(gpu).unwrap() }
    }

    fn begin(&mut self, brush: &Brush) {
        let fields = fields(&self.canvases);
        for (id, canvas) in IDS.into_iter().zip(&self.canvases) {
            self.painter.begin(id, &fields, brush, &canvas.segments, Reach([0.0, 65_535.0])).unwrap();
        }
    }

    fn extend(&mut self, dabs: [&[Dab]; 2]) -> Result<(), String> {
        let dabs = [(IDS[0], dabs[0]), (IDS[1], dabs[1])];
        let done = self.painter.extend(&mut self.pools, &fields(&self.canvases), &dabs);
        done.map(drop).map_err(|error| error.to_string())
    }

    fn finish(&mut self) -> burin::gpu::PaintedBricks {
        self.painter.finish(&mut self.pools, &fields(&self.canvases)).unwrap()
    }

    /// What is shown of the bricks that are touched.
    fn shown(&self) -> Vec<(FieldKey, BrickIndex, Brick)> {
        let fields = fields(&self.canvases);
        let live = |key: FieldKey, brick| self.painter.live(&self.pools, &fields, key.volume, brick).unwrap().unwrap();
        self.painter.touched().into_iter().map(|(key, brick)| (key, brick, live(key, brick))).collect()
    }
}

fn brushes() -> [Brush; 3] {
    let build_up = Brush { tip: Tip::BuildUp, strength: 0.3, radius_mm: 4.0, ..Brush::default() };
    [
        build_up,
        Brush { target: Target::Density(40_000.0), ..build_up },
        Brush { target: Target::Label(5), radius_mm: 4.0, ..Brush::default() },
    ]
}

fn row(grid: &Grid, from: f64, count: u32) -> Vec<Dab> {
    (0..count).map(|i| dab_at(grid, DVec3::new(from + 2.0 * f64::from(i), 20.0, 3.0), 4.0)).collect()
}

#[test]
fn what_one_volume_has_no_room_for_the_other_does_not_keep() {
    let Some(gpu) = gpu() else { return };
    for (brush, first) in brushes().into_iter().zip([1, 6, 1]) {
        let mut without = Two::new(&gpu);
        let grids = without.canvases.each_ref().map(|c| c.grid);
        let [a, b] = grids.map(|grid| row(&grid, 10.0, first));
        let [c, d] = grids.map(|grid| row(&grid, 14.0, 5));
        let far: Vec<_> = (0..49)
            .map(|i| {
                dab_at(&grids[1], DVec3::new(16.0 + 27.0 * f64::from(i % 7), 16.0 + 27.0 * f64::from(i / 7), 3.0), 4.0)
            })
            .collect();
        without.begin(&brush);
        without.extend([&a, &b]).unwrap();
        without.extend([&c, &d]).unwrap();
        let expected = without.finish();
        assert!(expected.iter().all(|(_, bricks)| !bricks.is_empty()));

        let mut two = Two::new(&gpu);
        two.painter.set_budget(10 << 20);
        two.begin(&brush);
        two.extend([&a, &b]).unwrap();
        let before = two.shown();
        // The first volume takes its dabs, new bricks among them, before the second says that it cannot.
        let error = two.extend([&row(&grids[0], 20.0, 22), &far]).unwrap_err();
        assert!(error.contains("stroke needs"), "{error}");
        assert_eq!(two.painter.dabs(IDS[0]).len(), a.len());
        for (key, brick, texels) in two.shown() {
            match before.iter().find(|(k, b, _)| (*k, *b) == (key, brick)) {
                Some((.., was)) => assert!(*was == texels, "{key:?} {brick:?}"),
                None => {
                    let kind = key.kind;
                    let was =
                        two.canvases[key.volume.0 as usize].field(kind).brick(BrickKey { level: 0, index: brick });
                    assert!(
                        was.unwrap().differing(&texels, [32, 32, 8], kind.format(TexelFormat::R16Unorm).bytes()) == 0
                    );
                }
            }
        }
        two.extend([&c, &d]).unwrap();
        assert!(two.finish() == expected, "{brush:?} {first}");
    }
}

#[test]
fn a_lost_device_replays_a_stroke_on_both_volumes() {
    let Some(gpu) = gpu() else { return };
    let doomed = Gpu::headless().unwrap();
    let [_, brush, _] = brushes();
    let [mut whole, mut two] = [&gpu, &doomed].map(Two::new);
    let grids = two.canvases.each_ref().map(|c| c.grid);
    let [a, b] = grids.map(|grid| row(&grid, 10.0, 4));
    let [c, d] = grids.map(|grid| row(&grid, 18.0, 9));
    for two in [&mut whole, &mut two] {
        two.begin(&brush);
        two.extend([&a, &b]).unwrap();
    }
    whole.extend([&c, &d]).unwrap();
    doomed.raw().0.destroy();
    let _ = doomed.wait();
    two.extend([&c, &d]).unwrap_err();
    two.pools = FieldPools::empty(&gpu, 64 << 20).unwrap();
    two.painter.replay(&gpu, &mut two.pools, &fields(&two.canvases)).unwrap();
    two.extend([&c, &d]).unwrap();
    assert!(two.finish() == whole.finish());
}

#[test]
fn a_volume_joins_a_stroke_before_its_first_dab_alone() {
    let Some(gpu) = gpu() else { return };
    let mut two = Two::new(&gpu);
    let brush = brushes()[0];
    let segments = Segments::default();
    let reach = Reach([0.0; 2]);
    let begin = |two: &mut Two, id| two.painter.begin(id, &fields(&two.canvases), &brush, &segments, reach);
    begin(&mut two, IDS[0]).unwrap();
    assert!(begin(&mut two, IDS[0]).is_err(), "twice");
    let dabs = row(&two.canvases[0].grid, 10.0, 2);
    let on = |two: &mut Two, id| two.painter.extend(&mut two.pools, &fields(&two.canvases), &[(id, &dabs)]);
    assert!(on(&mut two, IDS[1]).is_err(), "none runs there");
    on(&mut two, IDS[0]).unwrap();
    assert!(begin(&mut two, IDS[1]).is_err(), "it would lack dabs");
    assert_eq!(two.finish().len(), 1);
}
