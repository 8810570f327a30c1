//! Small flows between adjacent elements that bring the volume of the material in each element close to the volume of the
//! element: a screened graph Laplacian, solved by conjugate gradients.

use super::lists::Memory;

/// Weight of the volume that remains missing over that of the flows, both relative to the volumes of elements: a missing
/// volume that flows cannot provide is shared by about ten elements around.
const SCREENING: f64 = 0.01;
/// Missing volumes relative to the volumes of elements below which they are rounding errors.
const NEGLIGIBLE: f64 = 1e-12;
/// Largest number of iterations.
const MOST_ITERATIONS: usize = 50;

/// Flows between elements, as differences of a potential. All arrays are allocated at the start.
#[derive(Clone, Debug, Memory)]
pub struct VolumeBalance {
    /// Accuracy of the flows, relative to the largest missing volume.
    accuracy: f64,
    potential: Vec<f64>,
    residual: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
    diagonal: Vec<f64>,
}

impl VolumeBalance {
    /// Creates the arrays for a number of elements. `accuracy` is that of the flows, relative to the largest missing volume.
    pub fn new(elements: usize, accuracy: f64) -> VolumeBalance {
        let zeros = || vec![0.0; elements];
        VolumeBalance {
            accuracy,
            potential: zeros(),
            residual: zeros(),
            direction: zeros(),
            image: zeros(),
            diagonal: zeros(),
        }
    }

    /// Finds flows through `links` between elements that provide the `missing` volumes. Returns whether there are any.
    /// Elements without a link have no flows. Equation (18.18).
    pub fn solve(
        &mut self,
        links: impl Iterator<Item = [usize; 2]> + Clone,
        volume: impl Fn(usize) -> f64,
        missing: &[f64],
    ) -> bool {
        let is_within = |part: f64, list: &[f64]| (0..).zip(list).all(|(e, x)| x.abs() <= part * volume(e));
        if is_within(NEGLIGIBLE, missing) {
            return false;
        }
        let share = |(e, x): (usize, &f64)| if *x == 0.0 { 0.0 } else { x.abs() / volume(e) };
        let accuracy = self.accuracy * missing.iter().enumerate().map(share).fold(0.0, f64::max);
        for (e, diagonal) in self.diagonal.iter_mut().enumerate() {
            *diagonal = SCREENING * volume(e);
        }
        for [a, b] in links.clone() {
            let conductance = volume(a).min(volume(b));
            self.diagonal[a] += conductance;
            self.diagonal[b] += conductance;
        }
        self.potential.fill(0.0);
        self.direction.fill(0.0);
        self.residual.copy_from_slice(missing);
        let mut square = 0.0;
        for _ in 0..MOST_ITERATIONS {
            let previous = square;
            let preconditioned = |(r, d): (&f64, &f64)| if *d > 0.0 { r / d } else { 0.0 };
            square = self.residual.iter().zip(&self.diagonal).map(|x| x.0 * preconditioned(x)).sum::<f64>();
            let share = if previous > 0.0 { square / previous } else { 0.0 };
            for (direction, x) in self.direction.iter_mut().zip(self.residual.iter().zip(&self.diagonal)) {
                *direction = preconditioned(x) + share * *direction;
            }
            self.apply(links.clone(), &volume);
            let curvature = self.direction.iter().zip(&self.image).map(|(d, i)| d * i).sum::<f64>();
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let step = square / curvature;
            self.potential.iter_mut().zip(&self.direction).for_each(|(x, d)| *x += step * d);
            self.residual.iter_mut().zip(&self.image).for_each(|(r, i)| *r -= step * i);
            if is_within(accuracy, &self.residual) {
                break;
            }
        }
        true
    }

    /// Returns the volume that flows to element `a` from element `b`.
    pub fn flow(&self, [a, b]: [usize; 2], volume: impl Fn(usize) -> f64) -> f64 {
        volume(a).min(volume(b)) * (self.potential[a] - self.potential[b])
    }

    /// Applies the screened Laplacian to the direction.
    fn apply(&mut self, links: impl Iterator<Item = [usize; 2]>, volume: &impl Fn(usize) -> f64) {
        for (e, (image, x)) in self.image.iter_mut().zip(&self.direction).enumerate() {
            *image = SCREENING * volume(e) * x;
        }
        for [a, b] in links {
            let flow = volume(a).min(volume(b)) * (self.direction[a] - self.direction[b]);
            self.image[a] += flow;
            self.image[b] -= flow;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::VolumeBalance;

    /// In a row of equal elements a pair of opposite missing volumes is provided up to accuracy and screening, and flows are small
    /// where nothing is missing.
    #[test]
    fn opposite_missing_volumes_are_provided() {
        let mut balance = VolumeBalance::new(40, 1e-3);
        let links = || (1..40).map(|i| [i - 1, i]);
        let mut missing = vec![0.0; 40];
        (missing[20], missing[21]) = (0.03, -0.03);
        assert!(balance.solve(links(), |_| 1.0, &missing));
        let flows: Vec<f64> = links().map(|link| balance.flow(link, |_| 1.0)).collect();
        let provided = |e: usize| flows.get(e).unwrap_or(&0.0) - if e > 0 { flows[e - 1] } else { 0.0 };
        assert!((provided(20) / 0.03 - 1.0).abs() < 0.01 && (provided(21) / 0.03 + 1.0).abs() < 0.01, "{flows:?}");
        // Decay length of the screened potential: about 10 elements.
        assert!(flows[1].abs() < 0.02 * flows[20].abs());
        assert!((0..40).map(provided).sum::<f64>().abs() < 1e-16);
        assert!(!balance.solve(links(), |_| 1.0, &[1e-13; 40]));
    }
}
