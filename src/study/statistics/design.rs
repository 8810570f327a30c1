//! Points of the unit cube: at random, as Latin hypercubes, along Sobol's sequence; a seed gives the same points anywhere.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use sobol::Sobol;
use sobol::params::JoeKuoD6;

/// How points are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Each by itself.
    #[default]
    Random,
    /// One in each of as many strata of each parameter as there are points (McKay, Beckman and Conover, Technometrics 21
    /// (1979) 239).
    Latin,
    /// Sobol's sequence with the direction numbers of Joe and Kuo (SIAM J. Sci. Comput. 30 (2008) 2635), scrambled as Owen does.
    Sobol,
}

impl std::str::FromStr for Sampling {
    type Err = String;

    fn from_str(text: &str) -> Result<Sampling, String> {
        match text {
            "random" => Ok(Sampling::Random),
            "latin" => Ok(Sampling::Latin),
            "sobol" => Ok(Sampling::Sobol),
            _ => Err("random, latin and sobol there are".into()),
        }
    }
}

/// Points of `latin` and `sobol` come in so many sets, each spread by itself: how far sets differ is the error of what they say.
pub const SETS: usize = 16;
/// The most numbers of a point, by the table of direction numbers that is read.
pub const MOST_DIMENSIONS: usize = 100;
/// Streams of the cipher from here on shuffle and scramble; those below belong to points.
const SHUFFLES: u64 = 1 << 63;

/// The generator of a case: a stream of its own of the cipher ChaCha with eight rounds, so that no case waits for another.
pub fn draws(seed: u64, case: u64) -> ChaCha8Rng {
    let mut draws = ChaCha8Rng::seed_from_u64(seed);
    draws.set_stream(case);
    draws
}

/// A number from 0 to 1 by the 53 first bits of a draw.
pub fn unit(draw: u64) -> f64 {
    (draw >> 11) as f64 / (1_u64 << 53) as f64
}

/// A whole number below a count that is far from 2^64: what does not divide evenly is then too little to matter.
pub fn whole(draw: u64, count: usize) -> usize {
    ((u128::from(draw) * count as u128) >> 64) as usize
}

/// Points, one after the other.
pub struct Design {
    sampling: Sampling,
    dimensions: usize,
    seed: u64,
    /// Where sets begin, and the end of the last.
    sets: Vec<usize>,
    /// The next point, and the first of its set.
    next: usize,
    first: usize,
    set: SetState,
}

/// What the set of the next point needs.
enum SetState {
    None,
    /// A permutation of strata for each number of a point.
    Latin(Vec<Vec<u32>>),
    /// The sequence, and a key for each number of a point.
    Sobol(Box<Sobol<u64>>, Vec<u64>),
}

impl Design {
    /// So many points of so many numbers.
    pub fn new(sampling: Sampling, dimensions: usize, count: usize, seed: u64) -> Result<Design, String> {
        if sampling != Sampling::Random && count < 2 * SETS {
            return Err(format!("latin and sobol take {} points or more: they come in {SETS} sets", 2 * SETS));
        }
        if sampling == Sampling::Sobol && dimensions > MOST_DIMENSIONS {
            return Err(format!("sobol takes {MOST_DIMENSIONS} numbers a point at most, not {dimensions}"));
        }
        if u32::try_from(count).is_err() {
            return Err("more than 4 294 967 295 points".into());
        }
        let sets = Design::sets(sampling, count);
        Ok(Design { sampling, dimensions, seed, sets, next: 0, first: 0, set: SetState::None })
    }

    /// Where sets begin, and the end of the last.
    pub fn sets(sampling: Sampling, count: usize) -> Vec<usize> {
        match sampling {
            Sampling::Random => vec![0, count],
            _ => (0..=SETS).map(|set| set * count / SETS).collect(),
        }
    }

    /// Writes the next points, one row each; rows beyond the last are left.
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
            Sampling::Random => SetState::None,
            Sampling::Latin => SetState::Latin(keys.map(|mut draws| permutation(size, &mut draws)).collect()),
            Sampling::Sobol => {
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
                let at = self.next - self.first;
                for (u, strata) in point.iter_mut().zip(strata) {
                    *u = (f64::from(strata[at]) + unit(draws.next_u64())) / strata.len() as f64;
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

/// By Fisher and Yates.
fn permutation(size: usize, draws: &mut ChaCha8Rng) -> Vec<u32> {
    let mut list: Vec<u32> = (0..size as u32).collect();
    for i in (1..size).rev() {
        list.swap(i, whole(draws.next_u64(), i + 1));
    }
    list
}

/// Digits of a sequence that are scrambled; what is below is as random as they.
const SCRAMBLED: u32 = 32;

/// Owen's scrambling of binary digits (in Monte Carlo and Quasi-Monte Carlo Methods, Springer 1995, 299): a digit is turned or not by
/// a draw that belongs to the digits in front of it.
fn scrambled(digits: u64, key: u64) -> u64 {
    let mut turned = digits;
    for place in 0..SCRAMBLED {
        let before = digits.checked_shr(64 - place).unwrap_or(0);
        turned ^= (mix(key ^ mix(before << 6 | u64::from(place))) & 1) << (63 - place);
    }
    let low = u64::MAX >> SCRAMBLED;
    turned & !low | mix(key.wrapping_add(turned & !low)) & low
}

/// Steele, Lea and Flood's mixing of bits (OOPSLA 2014, SplitMix).
fn mix(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ bits >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(sampling: Sampling, dimensions: usize, count: usize, seed: u64) -> Vec<f64> {
        let mut points = vec![f64::NAN; dimensions * count];
        let mut design = Design::new(sampling, dimensions, count, seed).expect("a design");
        // In pieces, as whoever runs them takes them.
        points.chunks_mut(7 * dimensions).for_each(|piece| design.fill(piece));
        points
    }

    const ALL: [Sampling; 3] = [Sampling::Random, Sampling::Latin, Sampling::Sobol];

    #[test]
    fn points_follow_from_the_seed() {
        for sampling in ALL {
            let some = points(sampling, 3, 100, 7);
            assert!(some.iter().all(|u| (0.0..1.0).contains(u)), "{sampling:?}");
            assert_eq!(some, points(sampling, 3, 100, 7));
            assert_ne!(some, points(sampling, 3, 100, 8));
            let mean = some.iter().sum::<f64>() / 300.0;
            assert!((mean - 0.5).abs() < 4.0 / 3600_f64.sqrt(), "{sampling:?}: {mean}");
        }
        // A point at random knows nothing of how many there are.
        assert_eq!(points(Sampling::Random, 3, 100, 7)[..30], points(Sampling::Random, 3, 10, 7));
    }

    #[test]
    fn each_stratum_has_one_point() {
        for (sampling, count) in [(Sampling::Latin, 1003), (Sampling::Sobol, 16 * 64)] {
            let all = points(sampling, 4, count, 3);
            let sets = Design::sets(sampling, count);
            for ends in sets.windows(2) {
                let size = ends[1] - ends[0];
                for number in 0..4 {
                    let mut strata: Vec<usize> =
                        (ends[0]..ends[1]).map(|i| (all[4 * i + number] * size as f64) as usize).collect();
                    strata.sort_unstable();
                    assert!(strata.into_iter().eq(0..size), "{sampling:?}, number {number}");
                }
            }
        }
    }

    /// Source: the first points of Joe and Kuo's own generator (sobol.cc with new-joe-kuo-6.21201), in the order of Gray codes.
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

    /// Pairs of numbers fill elementary squares, too: of 64 points of a set each square of 8 x 8 has one in the first two numbers.
    #[test]
    fn scrambling_keeps_the_net() {
        let all = points(Sampling::Sobol, 2, 16 * 64, 11);
        for set in all.chunks(2 * 64) {
            let mut squares: Vec<usize> =
                set.chunks(2).map(|p| (8.0 * p[0]) as usize * 8 + (8.0 * p[1]) as usize).collect();
            squares.sort_unstable();
            assert!(squares.into_iter().eq(0..64));
        }
    }

    #[test]
    fn what_has_no_design_is_told() {
        for (sampling, dimensions, count) in [(Sampling::Latin, 2, 31), (Sampling::Sobol, 101, 64)] {
            assert!(Design::new(sampling, dimensions, count, 0).is_err());
        }
        assert!("halton".parse::<Sampling>().is_err());
    }
}
