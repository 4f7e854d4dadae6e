//! The nearest of many points.

use glam::{IVec3, Vec3};

/// Points a cell, about.
const POINTS_A_CELL: f32 = 2.0;

/// Points in the cells of a grid.
#[derive(Debug)]
pub(super) struct Nearest<'p> {
    points: &'p [Vec3],
    min: Vec3,
    cell: f32,
    cells: IVec3,
    /// Where each cell's points begin in `order`.
    begins: Vec<u32>,
    order: Vec<u32>,
}

impl<'p> Nearest<'p> {
    /// Among these; `None` without any.
    pub(super) fn of(points: &'p [Vec3]) -> Option<Self> {
        let first = *points.first()?;
        let (min, max) =
            points.iter().fold((first, first), |(min, max), p| (min.min(*p), max.max(*p)));
        // Points lie on surfaces: as many cells along a side as the root of their number.
        let along = (points.len() as f32 / POINTS_A_CELL / 3.0).sqrt().clamp(1.0, 256.0);
        let cell = ((max - min).max_element() / along).max(f32::MIN_POSITIVE);
        let cells = ((max - min) / cell).as_ivec3() + 1;
        let mut begins = vec![0; cells.element_product() as usize + 1];
        let mut nearest =
            Self { points, min, cell, cells, begins: Vec::new(), order: vec![0; points.len()] };
        let number = |p: &Vec3| nearest.number(nearest.cell_of(*p));
        let numbers: Vec<usize> = points.iter().map(number).collect();
        numbers.iter().for_each(|cell| begins[cell + 1] += 1);
        (1..begins.len()).for_each(|cell| begins[cell] += begins[cell - 1]);
        let mut next = begins.clone();
        for (point, cell) in numbers.iter().enumerate() {
            nearest.order[next[*cell] as usize] = point as u32;
            next[*cell] += 1;
        }
        nearest.begins = begins;
        Some(nearest)
    }

    fn cell_of(&self, p: Vec3) -> IVec3 {
        ((p - self.min) / self.cell).floor().as_ivec3().clamp(IVec3::ZERO, self.cells - 1)
    }

    fn number(&self, cell: IVec3) -> usize {
        ((cell.z * self.cells.y + cell.y) * self.cells.x + cell.x) as usize
    }

    /// The number of the point that is nearest to `p`, and how far it is.
    pub(super) fn to(&self, p: Vec3) -> (usize, f32) {
        let middle = self.cell_of(p);
        let mut best = (0, f32::INFINITY);
        for reach in 0..=self.cells.max_element() {
            // All that is left is at least this far from where `p` is, or would be.
            let away = p.distance(p.clamp(self.min, self.min + self.cell * self.cells.as_vec3()));
            if best.1 <= away.max((reach - 1) as f32 * self.cell) {
                break;
            }
            self.shell(middle, reach, |number| {
                let distance = p.distance(self.points[number]);
                if distance < best.1 {
                    best = (number, distance);
                }
            });
        }
        best
    }

    /// Every point of the cells that lie `reach` cells from the middle one.
    fn shell(&self, middle: IVec3, reach: i32, mut each: impl FnMut(usize)) {
        let low = (middle - reach).max(IVec3::ZERO);
        let high = (middle + reach).min(self.cells - 1);
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                let face = (z - middle.z).abs() == reach || (y - middle.y).abs() == reach;
                let step = if face || reach == 0 { 1 } else { 2 * reach };
                let first = if face { low.x } else { middle.x - reach };
                for x in (first..=high.x).step_by(step as usize).filter(|x| *x >= low.x) {
                    let number = self.number(IVec3::new(x, y, z));
                    let [from, to] = [number, number + 1].map(|n| self.begins[n] as usize);
                    self.order[from..to].iter().for_each(|point| each(*point as usize));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn as_by_looking_at_all() {
        let mut random = Random::new(3, [0; 3]);
        let mut point = |side: f32| Vec3::from([(); 3].map(|()| side * (random.next_f32() - 0.5)));
        let points: Vec<Vec3> = (0..700).map(|_| point(1.0) * Vec3::new(1.0, 2.0, 0.1)).collect();
        let nearest = Nearest::of(&points).unwrap();
        for _ in 0..500 {
            let p = point(4.0);
            let brute = points.iter().map(|q| p.distance(*q)).fold(f32::INFINITY, f32::min);
            let (number, distance) = nearest.to(p);
            assert_eq!((distance, points[number].distance(p)), (brute, brute));
        }
        assert!(Nearest::of(&[]).is_none());
    }
}
