//! Distances in a box of voxels against the nearest of all voxels, one by one.

use burin::math::DVec3;
use burin::volume::squared_distances;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn every_voxel_knows_its_distance_to_the_nearest_of_a_set() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for round in 0..40 {
        let size: [usize; 3] = std::array::from_fn(|_| rng.random_range(1..8));
        let spacing = DVec3::from_array(std::array::from_fn(|_| rng.random_range(0.2..3.0)));
        let count = size.iter().product::<usize>();
        // From none to nearly all.
        let share = f64::from(round) / 40.0;
        let goal: Vec<bool> = (0..count).map(|_| rng.random_range(0.0..1.0) < share).collect();
        let place = |i: usize| {
            let at = [i % size[0], i / size[0] % size[1], i / size[0] / size[1]];
            DVec3::from_array(at.map(|v| v as f64)) * spacing
        };
        let found = squared_distances(size, spacing, |i| goal[i]);
        for (i, found) in found.into_iter().enumerate() {
            let to = (0..count).filter(|&j| goal[j]).map(|j| place(i).distance_squared(place(j)));
            let nearest = to.fold(f64::INFINITY, f64::min);
            assert!(found == nearest || (found - nearest).abs() < 1e-9 * (1.0 + nearest), "{found} for {nearest}");
        }
    }
}
