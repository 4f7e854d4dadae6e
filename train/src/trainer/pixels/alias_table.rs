//! Random choice among many, each with a probability of its own.

use crate::random::Random;

/// An alias table (Walker 1977, built as Vose 1991 does): every place keeps a choice
/// for itself with some probability, and else hands it to one other place. A draw is
/// one read, however many places there are.
#[derive(Clone, Debug)]
pub(crate) struct AliasTable {
    places: Vec<Place>,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    /// Probability of keeping the choice.
    keeps: f32,
    /// Who gets it otherwise.
    other: u32,
}

impl AliasTable {
    /// All of `n` equally often.
    pub(crate) fn uniform(n: usize) -> Self {
        Self { places: vec![Place { keeps: 1.0, other: 0 }; n] }
    }

    /// Each as often as its size says; sizes are positive and 1 on average.
    pub(crate) fn update(&mut self, sizes: &[f32]) {
        let places = &mut self.places;
        places.clear();
        places.extend((0..).zip(sizes).map(|(i, size)| Place { keeps: *size, other: i }));
        // Two walks: over those that have too much, and over those that have too
        // little and are filled up by the former.
        let next = |places: &[Place], from: usize, is_rich: bool| {
            (from..places.len()).find(|i| (places[*i].keeps > 1.0) == is_rich)
        };
        let (mut rich, mut walked) = (next(places, 0, true), next(places, 0, false));
        let mut poor = walked;
        while let (Some(from), Some(to), Some(at)) = (rich, poor, walked) {
            places[to].other = from as u32;
            places[from].keeps -= 1.0 - places[to].keeps;
            let fell = places[from].keeps <= 1.0;
            if fell {
                rich = next(places, from + 1, true);
            }
            if fell && from < at {
                // It has too little now, and the walk has passed it.
                poor = Some(from);
            } else {
                walked = next(places, at + 1, false);
                poor = walked;
            }
        }
    }

    /// The number of a place.
    #[inline]
    pub(crate) fn draw(&self, random: &mut Random) -> usize {
        let i = random.below(self.places.len());
        let Place { keeps, other } = self.places[i];
        if random.next_f32() < keeps { i } else { other as usize }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The probability of each place.
    fn probabilities(alias: &AliasTable) -> Vec<f64> {
        let n = alias.places.len();
        let mut all = vec![0.0; n];
        for (i, place) in alias.places.iter().enumerate() {
            let keeps = f64::from(place.keeps).clamp(0.0, 1.0);
            all[i] += keeps / n as f64;
            all[place.other as usize] += (1.0 - keeps) / n as f64;
        }
        all
    }

    #[test]
    fn places_are_as_probable_as_they_are_large() {
        let mut random = Random::new(1, [0; 3]);
        let mut alias = AliasTable::uniform(3);
        assert_eq!(probabilities(&alias), [1.0 / 3.0; 3]);
        for n in [1, 2, 3, 10, 1000, 100_000] {
            for power in [0.0, 1.0, 8.0, -0.9] {
                let sizes: Vec<f32> =
                    (0..n).map(|_| random.next_f32().max(1e-6).powf(power)).collect();
                let mean = sizes.iter().map(|s| f64::from(*s)).sum::<f64>() / f64::from(n);
                let sizes: Vec<f32> = sizes.iter().map(|s| (f64::from(*s) / mean) as f32).collect();
                alias.update(&sizes);
                for (found, size) in probabilities(&alias).iter().zip(&sizes) {
                    let expected = f64::from(*size) / f64::from(n);
                    assert!((found - expected).abs() < 1e-6, "{n}, {power}: {found}, {expected}");
                }
            }
        }
    }

    #[test]
    fn draws_follow_the_probabilities() {
        let mut alias = AliasTable::uniform(4);
        alias.update(&[0.1, 2.4, 0.5, 1.0]);
        let (mut random, mut counts) = (Random::new(2, [0; 3]), [0.0; 4]);
        (0..400_000).for_each(|_| counts[alias.draw(&mut random)] += 1e-5);
        for (count, expected) in counts.iter().zip([0.1, 2.4, 0.5, 1.0]) {
            assert!(f64::abs(count - expected) < 0.02, "{counts:?}");
        }
    }
}
