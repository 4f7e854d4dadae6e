//! Whether a place is free: what occupancy alone can say.

use crate::occupancy::{BLOCK, BLOCK_BYTES};
use crate::query::Probe;
use crate::query::similarity::are_places;

impl Probe<'_> {
    /// Whether there may be something at `point`: inside the model's box, and in an
    /// occupied cell. [`density`](Self::density) is 0 wherever this is false.
    ///
    /// A model without occupancy is occupied all over its box. So is a point that is
    /// nowhere (NaN, infinite or beyond 1e11 units): what is not known is not free.
    #[must_use]
    pub fn occupied(&self, point: [f32; 3]) -> bool {
        !are_places(&point) || self.place(point).is_some()
    }

    /// Whether no occupied cell touches the ball of `radius` around `center`, both in the
    /// caller's units: nowhere in it is any density. Never true by mistake: rounding makes
    /// the ball larger. A ball that is farther than a cell's diagonal from all that has
    /// density may still touch an occupied cell, which need not be full.
    ///
    /// Blocks of 8×8×8 cells are walked, empty ones in one step, with a
    /// [table](crate::Model::with_table) up to 4×4×4 of them, and only blocks that the ball
    /// touches are looked into.
    ///
    /// In a model without occupancy, balls outside its box alone are clear: no number of
    /// samples would prove that a field is empty between them. A ball without sound numbers
    /// is not clear.
    #[must_use]
    pub fn sphere_clear(&self, center: [f32; 3], radius: f32) -> bool {
        if !(are_places(&center) && radius >= 0.0 && radius.is_finite()) {
            return false;
        }
        let ball = self.ball(center, radius);
        let [min, max] = self.model.space.bounds().map(|corner| self.map.apply(corner));
        if ball.misses(min, max) {
            return true;
        }
        let Some(occupancy) = &self.model.occupancy else { return false };
        let resolution = occupancy.resolution();
        let ball = Ball {
            center: ball.center.map(|c| c * resolution as f32),
            radius: ball.radius * resolution as f32,
        };
        // Numbers that `as` cuts off end inside the grid, on the ball's side.
        let blocks = |a: usize| {
            let block = |cell: f32| (cell as u32).min(resolution - 1) / BLOCK;
            [block(ball.center[a] - ball.radius), block(ball.center[a] + ball.radius)]
        };
        let [x, y, z] = [blocks(0), blocks(1), blocks(2)];
        for bz in z[0]..=z[1] {
            for by in y[0]..=y[1] {
                let mut bx = x[0];
                while bx <= x[1] {
                    // Cubes of empty blocks lie at multiples of their side.
                    let empty = occupancy.empty_blocks([bx, by, bz]);
                    if empty > 0 {
                        bx = (bx + 1).next_multiple_of(empty);
                        continue;
                    }
                    let cells = occupancy.block(bx, by, bz);
                    if cells.is_some_and(|bits| ball.touches([bx, by, bz], bits)) {
                        return false;
                    }
                    bx += 1;
                }
            }
        }
        true
    }

    /// The ball in unit coordinates, larger by what rounding may amount to: its own, and
    /// that of looking up any point of it.
    fn ball(&self, center: [f32; 3], radius: f32) -> Ball {
        let [min, max] = self.model.space.bounds();
        let corners = (0..3).map(|a| min[a].abs() + max[a].abs()).fold(0.0, f32::max);
        let [rounding, stretch] = self.similarity.error(center);
        let rounding = rounding + 16.0 * f32::EPSILON * corners;
        let radius = radius / self.similarity.scale * stretch + rounding;
        Ball {
            center: self.map.apply(self.similarity.to_model(center)),
            radius: radius * (1.0 + 8.0 * f32::EPSILON) * self.map.scale,
        }
    }
}

struct Ball {
    center: [f32; 3],
    radius: f32,
}

impl Ball {
    /// Whether it touches no part of a box, not even a face.
    fn misses(&self, min: [f32; 3], max: [f32; 3]) -> bool {
        let square = |a: usize| {
            let away = (min[a] - self.center[a]).max(self.center[a] - max[a]).max(0.0);
            away * away
        };
        square(0) + square(1) + square(2) > self.radius * self.radius
    }

    /// Whether it touches an occupied cell of this block, where cells are 1 wide.
    fn touches(&self, block: [u32; 3], bits: &[u8; BLOCK_BYTES]) -> bool {
        let corner = block.map(|b| (b * BLOCK) as f32);
        let misses = |from: [f32; 3], size: [f32; 3]| {
            let min = [0, 1, 2].map(|a| corner[a] + from[a]);
            self.misses(min, [0, 1, 2].map(|a| min[a] + size[a]))
        };
        if misses([0.0; 3], [BLOCK as f32; 3]) {
            return false;
        }
        let rows = (0u32..).zip(bits).filter(|(_, cells)| **cells != 0);
        rows.map(|(row, cells)| ((row % BLOCK) as f32, (row / BLOCK) as f32, cells))
            .filter(|(y, z, _)| !misses([0.0, *y, *z], [BLOCK as f32, 1.0, 1.0]))
            .any(|(y, z, cells)| {
                let occupied = (0..BLOCK).filter(|x| cells >> x & 1 == 1);
                occupied.into_iter().any(|x| !misses([x as f32, y, z], [1.0; 3]))
            })
    }
}
