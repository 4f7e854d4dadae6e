//! The nearest of many points.

use glam::Vec3;

/// Points of a leaf at most.
const LEAF: usize = 8;

/// Points in a k-d tree: the middle of a part is its median along an axis, which parts take by
/// turns. A point far from all of them takes hardly longer than one beside them.
#[derive(Debug)]
pub(super) struct Nearest<'p> {
    points: &'p [Vec3],
    order: Vec<u32>,
}

impl<'p> Nearest<'p> {
    /// Among these; `None` without any.
    pub(super) fn of(points: &'p [Vec3]) -> Option<Self> {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        split(points, &mut order, 0);
        (!points.is_empty()).then_some(Self { points, order })
    }

    /// The number of the point that is nearest to `p`, and how far it is.
    pub(super) fn to(&self, p: Vec3) -> (usize, f32) {
        let mut best = (0, f32::INFINITY);
        self.search(&self.order, 0, p, &mut best);
        best
    }

    fn search(&self, part: &[u32], axis: usize, p: Vec3, best: &mut (usize, f32)) {
        let mut look = |number: u32| {
            let distance = p.distance(self.points[number as usize]);
            if distance < best.1 {
                *best = (number as usize, distance);
            }
        };
        if part.len() <= LEAF {
            part.iter().for_each(|number| look(*number));
            return;
        }
        let (low, rest) = part.split_at(part.len() / 2);
        let Some((middle, high)) = rest.split_first() else { return };
        look(*middle);
        let past = p[axis] - self.points[*middle as usize][axis];
        let (near, far) = if past < 0.0 { (low, high) } else { (high, low) };
        let next = (axis + 1) % 3;
        self.search(near, next, p, best);
        if past.abs() < best.1 {
            self.search(far, next, p, best);
        }
    }
}

/// Puts the median in the middle, smaller ones before it and larger ones after it.
fn split(points: &[Vec3], part: &mut [u32], axis: usize) {
    if part.len() <= LEAF {
        return;
    }
    let along = |number: &u32| points[*number as usize][axis];
    let middle = part.len() / 2;
    let (low, _, high) = part.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
    let next = (axis + 1) % 3;
    rayon::join(|| split(points, low, next), || split(points, high, next));
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

    /// All far away, many of them in one place: nothing is looked at that need not be.
    #[test]
    fn far_away_and_in_one_place() {
        let points = vec![Vec3::ONE; 5000];
        let nearest = Nearest::of(&points).unwrap();
        let (number, distance) = nearest.to(Vec3::splat(-1e6));
        assert_eq!(points[number].distance(Vec3::splat(-1e6)), distance);
    }
}
