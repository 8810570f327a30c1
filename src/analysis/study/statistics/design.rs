//! Sample points of the unit cube: random, Latin hypercube or Sobol sequence. The same seed gives the same points on
//! every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use sobol::Sobol;
use sobol::params::JoeKuoD6;

/// Sampling scheme of points in the unit cube.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplingScheme {
    /// Independent random points.
    #[default]
    Random,
    /// Latin hypercube: one point in each stratum of each parameter (McKay, Beckman and Conover, Technometrics 21
    /// (1979) 239).
    Latin,
    /// Sobol sequence with the direction numbers of Joe and Kuo (SIAM J. Sci. Comput. 30 (2008) 2635) and Owen
    /// scrambling.
    Sobol,
}

impl std::str::FromStr for SamplingScheme {
    type Err = String;

    fn from_str(text: &str) -> Result<SamplingScheme, String> {
        match text {
            "random" => Ok(SamplingScheme::Random),
            "latin" => Ok(SamplingScheme::Latin),
            "sobol" => Ok(SamplingScheme::Sobol),
            _ => Err("expected random, latin or sobol".into()),
        }
    }
}

/// Number of independent sets of points of `latin` and `sobol`; the error is estimated from the differences between
/// sets.
pub const SETS: usize = 16;
/// Largest dimension of a Sobol point, limited by the table of direction numbers.
pub const MOST_DIMENSIONS: usize = 100;
/// First stream of the generator for shuffling and scrambling; lower streams are for points.
const SHUFFLES: u64 = 1 << 63;

/// Returns the random number generator of a case: a separate stream of ChaCha with eight rounds, so that cases are
/// independent.
pub fn draws(seed: u64, case: u64) -> ChaCha8Rng {
    let mut draws = ChaCha8Rng::seed_from_u64(seed);
    draws.set_stream(case);
    draws
}

/// Converts the upper 53 bits of a draw to a number in [0, 1).
pub fn unit(draw: u64) -> f64 {
    (draw >> 11) as f64 / (1_u64 << 53) as f64
}

/// Converts a draw to an integer below `count`; the bias is negligible for `count` far below 2^64.
pub fn whole(draw: u64, count: usize) -> usize {
    ((u128::from(draw) * count as u128) >> 64) as usize
}

/// Generator of sample points.
pub struct SampleDesign {
    sampling: SamplingScheme,
    dimensions: usize,
    seed: u64,
    /// Start index of each set, followed by the end of the last set.
    sets: Vec<usize>,
    /// Index of the next point, and of the first point of its set.
    next: usize,
    first: usize,
    set: SetState,
}

/// State of the set of the next point.
enum SetState {
    None,
    /// Permutation of the strata, one per dimension.
    Latin(Vec<Vec<u32>>),
    /// Sequence, and a scrambling key per dimension.
    Sobol(Box<Sobol<u64>>, Vec<u64>),
}

impl SampleDesign {
    /// Creates a generator of `count` points.
    ///
    /// # Errors
    /// If `latin` or `sobol` has fewer than `2 * SETS` points, or `sobol` more than [`MOST_DIMENSIONS`].
    pub fn new(sampling: SamplingScheme, dimensions: usize, count: usize, seed: u64) -> Result<SampleDesign, String> {
        if sampling != SamplingScheme::Random && count < 2 * SETS {
            return Err(format!(
                "latin and sobol need at least {} points, because they are divided into {SETS} sets",
                2 * SETS
            ));
        }
        if sampling == SamplingScheme::Sobol && dimensions > MOST_DIMENSIONS {
            return Err(format!("sobol allows at most {MOST_DIMENSIONS} dimensions, found {dimensions}"));
        }
        if u32::try_from(count).is_err() {
            return Err("more than 4 294 967 295 points are not allowed".into());
        }
        let sets = SampleDesign::sets(sampling, count);
        Ok(SampleDesign { sampling, dimensions, seed, sets, next: 0, first: 0, set: SetState::None })
    }

    /// Returns the start index of each set, followed by the end of the last set.
    pub fn sets(sampling: SamplingScheme, count: usize) -> Vec<usize> {
        match sampling {
            SamplingScheme::Random => vec![0, count],
            _ => (0..=SETS).map(|set| set * count / SETS).collect(),
        }
    }

    /// Writes the next points, one row each; rows beyond the last point are unchanged.
    pub fn fill(&mut self, points: &mut [f64]) {
        for point in points.chunks_exact_mut(self.dimensions.max(1)) {
            match self.sets.binary_search(&self.next) {
                Ok(set) if set + 1 == self.sets.len() => return,
                Ok(set) => {
                    self.first = self.next;
                    self.set = self.begin(set, self.sets[set + 1] - self.next);
                }
                Err(_) => {}
            }
            self.point(point);
            self.next += 1;
        }
    }

    fn begin(&self, set: usize, size: usize) -> SetState {
        let keys = (0..self.dimensions).map(|i| draws(self.seed, SHUFFLES + (set * self.dimensions + i) as u64));
        match self.sampling {
            SamplingScheme::Random => SetState::None,
            SamplingScheme::Latin => SetState::Latin(keys.map(|mut draws| permutation(size, &mut draws)).collect()),
            SamplingScheme::Sobol => {
                let sequence = Sobol::new(self.dimensions, &JoeKuoD6::minimal());
                SetState::Sobol(Box::new(sequence), keys.map(|mut draws| draws.next_u64()).collect())
            }
        }
    }

    fn point(&mut self, point: &mut [f64]) {
        let mut draws = draws(self.seed, self.next as u64);
        match &mut self.set {
            SetState::None => point.iter_mut().for_each(|u| *u = unit(draws.next_u64())),
            SetState::Latin(strata) => {
                let index_in_set = self.next - self.first;
                for (u, strata) in point.iter_mut().zip(strata) {
                    *u = (f64::from(strata[index_in_set]) + unit(draws.next_u64())) / strata.len() as f64;
                }
            }
            SetState::Sobol(sequence, keys) => {
                let digits = sequence.next().unwrap_or_default();
                for ((u, digits), key) in point.iter_mut().zip(digits).zip(keys) {
                    *u = unit(scrambled(digits, *key));
                }
            }
        }
    }
}

/// Returns a random permutation (Fisher-Yates).
fn permutation(size: usize, draws: &mut ChaCha8Rng) -> Vec<u32> {
    let mut list: Vec<u32> = (0..size as u32).collect();
    for i in (1..size).rev() {
        list.swap(i, whole(draws.next_u64(), i + 1));
    }
    list
}

/// Number of scrambled leading binary digits; the digits below are random.
const SCRAMBLED: u32 = 32;

/// Scrambles binary digits as Owen does (in Monte Carlo and Quasi-Monte Carlo Methods, Springer 1995, 299): a random
/// bit that depends on the preceding digits flips each digit or not.
fn scrambled(digits: u64, key: u64) -> u64 {
    let mut turned = digits;
    for place in 0..SCRAMBLED {
        let preceding_digits = digits.checked_shr(64 - place).unwrap_or(0);
        turned ^= (mix(key ^ mix(preceding_digits << 6 | u64::from(place))) & 1) << (63 - place);
    }
    let low = u64::MAX >> SCRAMBLED;
    turned & !low | mix(key.wrapping_add(turned & !low)) & low
}

/// Mixes bits with the function of SplitMix (Steele, Lea and Flood, OOPSLA 2014).
pub fn mix(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ bits >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(sampling: SamplingScheme, dimensions: usize, count: usize, seed: u64) -> Vec<f64> {
        let mut points = vec![f64::NAN; dimensions * count];
        let mut design = SampleDesign::new(sampling, dimensions, count, seed).expect("a design");
        // In pieces, as in a Monte Carlo study.
        points.chunks_mut(7 * dimensions).for_each(|piece| design.fill(piece));
        points
    }

    const ALL: [SamplingScheme; 3] = [SamplingScheme::Random, SamplingScheme::Latin, SamplingScheme::Sobol];

    #[test]
    fn points_depend_on_the_seed_only() {
        for sampling in ALL {
            let some = points(sampling, 3, 100, 7);
            assert!(some.iter().all(|u| (0.0..1.0).contains(u)), "{sampling:?}");
            assert_eq!(some, points(sampling, 3, 100, 7));
            assert_ne!(some, points(sampling, 3, 100, 8));
            let mean = some.iter().sum::<f64>() / 300.0;
            assert!((mean - 0.5).abs() < 4.0 / 3600_f64.sqrt(), "{sampling:?}: {mean}");
        }
        // Random points do not depend on the number of points.
        assert_eq!(points(SamplingScheme::Random, 3, 100, 7)[..30], points(SamplingScheme::Random, 3, 10, 7));
    }

    #[test]
    fn each_stratum_has_one_point() {
        for (sampling, count) in [(SamplingScheme::Latin, 1003), (SamplingScheme::Sobol, 16 * 64)] {
            let coordinates = points(sampling, 4, count, 3);
            let sets = SampleDesign::sets(sampling, count);
            for ends in sets.windows(2) {
                let size = ends[1] - ends[0];
                for number in 0..4 {
                    let mut strata: Vec<usize> =
                        (ends[0]..ends[1]).map(|i| (coordinates[4 * i + number] * size as f64) as usize).collect();
                    strata.sort_unstable();
                    assert!(strata.into_iter().eq(0..size), "{sampling:?}, number {number}");
                }
            }
        }
    }

    /// Source: the first points of the generator of Joe and Kuo (sobol.cc with new-joe-kuo-6.21201), in Gray code
    /// order.
    #[test]
    fn the_sequence_is_that_of_joe_and_kuo() {
        let known = [
            [0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25],
            [0.25, 0.75, 0.75],
            [0.375, 0.375, 0.625],
            [0.875, 0.875, 0.125],
            [0.625, 0.125, 0.875],
            [0.125, 0.625, 0.375],
        ];
        let sequence = Sobol::<u64>::new(3, &JoeKuoD6::minimal());
        for (point, known) in sequence.zip(known) {
            assert_eq!(point.iter().map(|digits| unit(*digits)).collect::<Vec<_>>(), known);
        }
    }

    /// The 64 points of a set have one point in each of the 8 x 8 squares of the first two dimensions.
    #[test]
    fn scrambling_preserves_the_net_property() {
        let coordinates = points(SamplingScheme::Sobol, 2, 16 * 64, 11);
        for set in coordinates.chunks(2 * 64) {
            let mut squares: Vec<usize> =
                set.chunks(2).map(|p| (8.0 * p[0]) as usize * 8 + (8.0 * p[1]) as usize).collect();
            squares.sort_unstable();
            assert!(squares.into_iter().eq(0..64));
        }
    }

    #[test]
    fn invalid_designs_are_errors() {
        for (sampling, dimensions, count) in [(SamplingScheme::Latin, 2, 31), (SamplingScheme::Sobol, 101, 64)] {
            assert!(SampleDesign::new(sampling, dimensions, count, 0).is_err());
        }
        assert!("halton".parse::<SamplingScheme>().is_err());
    }
}
