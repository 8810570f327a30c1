//! Masses of the fragments of an expanding body by the laws of Mott and of Grady, from the strain rates of its elements.

use super::StudyError;
use super::chart::{AxisScale, Chart, ChartSeries, SeriesForm};

/// Element of a body that expands along its circumference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpandingElement {
    /// Mass of the whole ring.
    pub mass: f64,
    /// Radius of the centroid, length.
    pub radius: f64,
    /// Circumferential strain rate v_r/r, 1/time; above zero.
    pub rate: f64,
}

/// Mean length of the fragments of Mott's process in a long ring, in units of `x0`: 1.669 ± 0.003 (95 % interval, 144 000
/// simulated fragments). Mott (1947, p. 305) found about 1.5 by a graphical construction for a ring of 20 `x0`.
const MEAN_SPACING: f64 = 1.67;

/// Law of the mean length of fragments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FragmentLaw {
    /// Statistical fracture: flow stress, and the dimensionless constant gamma by which the rate of fracture per strain
    /// grows.
    Mott { flow_stress: f64, gamma: f64 },
    /// Balance of kinetic and fracture energy: energy per area of new surface.
    Grady { fracture_energy: f64 },
}

/// Dimensions in which a body breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FragmentShape {
    /// Along the circumference only: each fragment has the whole section of the body.
    Ring,
    /// Into squares through a thickness.
    Shell(f64),
    /// Into cubes.
    Solid,
}

impl FragmentLaw {
    /// Returns the name of the law.
    pub fn name(self) -> &'static str {
        match self {
            FragmentLaw::Mott { .. } => "Mott",
            FragmentLaw::Grady { .. } => "Grady",
        }
    }

    /// Returns the mean length of fragments at a density and strain rate. Equations (19.1), (19.2).
    pub fn length(self, density: f64, rate: f64) -> f64 {
        match self {
            FragmentLaw::Mott { flow_stress, gamma } => {
                MEAN_SPACING * (2.0 * flow_stress / (density * gamma)).sqrt() / rate
            }
            FragmentLaw::Grady { fracture_energy } => libm::cbrt(24.0 * fracture_energy / (density * rate * rate)),
        }
    }
}

impl FragmentShape {
    /// Returns the number of dimensions.
    fn dimensions(self) -> i32 {
        match self {
            FragmentShape::Ring => 1,
            FragmentShape::Shell(_) => 2,
            FragmentShape::Solid => 3,
        }
    }
}

/// Fragments of a part of the body: its mass, and the mean mass of its fragments.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FragmentGroup {
    mass: f64,
    mean: f64,
}

/// Fragments of a body by one law.
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentSet {
    /// Name of the law.
    pub law: &'static str,
    /// Mean length, weighted by mass.
    pub length: f64,
    /// Expected number of fragments.
    pub number: f64,
    /// Mean mass: mass of the body over the number.
    pub mean_mass: f64,
    dimensions: i32,
    groups: Vec<FragmentGroup>,
}

impl FragmentSet {
    /// Computes the fragments of a body with a density. A fragment has at most the mass of the body.
    pub fn of(elements: &[ExpandingElement], density: f64, law: FragmentLaw, shape: FragmentShape) -> FragmentSet {
        let total: f64 = elements.iter().map(|element| element.mass).sum();
        let group = |element: &ExpandingElement| {
            let length = law.length(density, element.rate);
            let mean = match shape {
                FragmentShape::Ring => total * length / (2.0 * std::f64::consts::PI * element.radius),
                FragmentShape::Shell(thickness) => density * thickness * length * length,
                FragmentShape::Solid => density * length * length * length,
            };
            FragmentGroup { mass: element.mass, mean: mean.min(total) }
        };
        let groups: Vec<FragmentGroup> = elements.iter().map(group).collect();
        let number: f64 = groups.iter().map(|group| group.mass / group.mean).sum();
        let length = elements.iter().map(|e| e.mass * law.length(density, e.rate)).sum::<f64>() / total;
        let dimensions = shape.dimensions();
        FragmentSet { law: law.name(), length, number, mean_mass: total / number, dimensions, groups }
    }

    /// Returns the expected number of fragments that are heavier than a mass. Equation (19.3).
    pub fn number_above(&self, mass: f64) -> f64 {
        let factorial = f64::from((1..=self.dimensions).product::<i32>());
        let root = |x: f64| match self.dimensions {
            1 => x,
            2 => x.sqrt(),
            _ => libm::cbrt(x),
        };
        let above = |group: &FragmentGroup| group.mass / group.mean * libm::exp(-root(mass * factorial / group.mean));
        self.groups.iter().map(above).sum()
    }
}

/// Parses masses of counted fragments: lines `mass` or `mass,count`; the first line may be a header.
///
/// # Errors
/// If a line is not one or two numbers above zero, or there are none.
pub fn counted_masses(text: &str) -> Result<Vec<f64>, StudyError> {
    let mut masses = Vec::new();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let cells: Option<Vec<f64>> = line.split(',').map(|cell| cell.trim().parse().ok()).collect();
        match cells.as_deref() {
            Some(&[mass]) if mass > 0.0 && mass.is_finite() => masses.push(mass),
            Some(&[mass, count]) if mass > 0.0 && mass.is_finite() && (1.0..1e7).contains(&count) => {
                masses.extend(std::iter::repeat_n(mass, count as usize));
            }
            None if index == 0 => {}
            _ => {
                let found = format!("line {}: expected a mass, or a mass and a count, found `{line}`", index + 1);
                return Err(StudyError::Setting(found));
            }
        }
    }
    if masses.is_empty() {
        return Err(StudyError::Setting("no masses: expected one mass per line, or a mass and a count".into()));
    }
    masses.sort_by(f64::total_cmp);
    Ok(masses)
}

/// Number of points of a curve.
const POINTS: usize = 60;
/// Range of masses of a curve, in units of the mean mass.
const RANGE: [f64; 2] = [1e-3, 30.0];

/// Returns the chart of the number of fragments over their mass, with the counted masses, which are in ascending order.
pub fn chart(title: &str, sets: &[FragmentSet], counted: &[f64]) -> Chart {
    let curve = |set: &FragmentSet| {
        let ratio = RANGE[1] / RANGE[0];
        let mass = |i: usize| set.mean_mass * RANGE[0] * libm::pow(ratio, i as f64 / (POINTS - 1) as f64);
        let points = (0..POINTS).map(mass).map(|mass| (mass, set.number_above(mass)));
        ChartSeries::new(set.law, SeriesForm::Line, points.filter(|point| point.1 > 0.1).collect())
    };
    let mut series: Vec<ChartSeries> = sets.iter().map(curve).collect();
    if !counted.is_empty() {
        let points = counted.iter().enumerate().map(|(i, mass)| (*mass, (counted.len() - i) as f64));
        series.push(ChartSeries::new("counted", SeriesForm::Marks, points.collect()));
    }
    Chart { scale: AxisScale::LogLog, ..Chart::new(title, ["mass of a fragment", "fragments not lighter"], series) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::statistics::design::{draws, unit};
    use rand_chacha::rand_core::RngCore as _;

    /// Source: Mott's process itself. Fractures begin at random places at a rate that grows as exp(gamma strain), and each
    /// relieves a zone that grows with the root of the strain, in units of x0 and 1/gamma.
    #[test]
    fn mean_length_matches_motts_process() {
        let (mut random, length) = (draws(7, 0), 1500.0);
        let mut next = || unit(random.next_u64());
        // Places and strains of the fractures; the measure exp(strain) of candidates is uniform.
        let mut fractures: Vec<[f64; 2]> = Vec::new();
        let mut measure = 0.0;
        while measure < 20.0 {
            measure -= libm::log(1.0 - next()) / length;
            let (place, strain) = (length * next(), libm::log(measure));
            let distance = |other: f64| (place - other).abs().min(length - (place - other).abs());
            if fractures.iter().all(|[other, begun]| distance(*other) > (strain - begun).sqrt()) {
                fractures.push([place, strain]);
            }
        }
        let mean = length / fractures.len() as f64;
        assert!((mean / MEAN_SPACING - 1.0).abs() < 0.04, "{mean}");
        let law = FragmentLaw::Mott { flow_stress: 3e8, gamma: 20.0 };
        let x0 = (2.0 * 3e8 / (2700.0 * 20.0_f64)).sqrt() / 1e4;
        assert!((law.length(2700.0, 1e4) / x0 - MEAN_SPACING).abs() < 1e-12);
    }

    /// Source: the minimum over the length s of the kinetic energy rho rate^2 s^2/24 and the surface energy 2 Gamma/s of a
    /// volume, by differences.
    #[test]
    fn grady_length_has_the_least_energy() {
        let [density, rate, fracture_energy] = [7800.0, 2e4, 5e4];
        let length = FragmentLaw::Grady { fracture_energy }.length(density, rate);
        let energy = |s: f64| density * rate * rate * s * s / 24.0 + 2.0 * fracture_energy / s;
        assert!(energy(length) < energy(0.999 * length) && energy(length) < energy(1.001 * length), "{length}");
    }

    /// A uniform ring has `2 pi r/l` fragments; the masses of all fragments are the mass of the body.
    #[test]
    fn masses_of_all_fragments_are_the_mass_of_the_body() {
        let ring = [ExpandingElement { mass: 0.02, radius: 0.016, rate: 1e4 }; 3];
        let law = FragmentLaw::Mott { flow_stress: 1e8, gamma: 30.0 };
        let length = law.length(2700.0, 1e4);
        let set = FragmentSet::of(&ring, 2700.0, law, FragmentShape::Ring);
        assert!((set.number / (2.0 * std::f64::consts::PI * 0.016 / length) - 1.0).abs() < 1e-12);
        for shape in [FragmentShape::Ring, FragmentShape::Shell(1e-3), FragmentShape::Solid] {
            let set = FragmentSet::of(&ring, 2700.0, law, shape);
            assert!((set.number_above(0.0) / set.number - 1.0).abs() < 1e-12);
            // The integral of the number above m over m, with m = x^3 mean.
            let step = 2e-4;
            let part = |i: usize| {
                let x = (i as f64 + 0.5) * step;
                set.number_above(x * x * x * set.mean_mass) * 3.0 * x * x * step * set.mean_mass
            };
            let mass: f64 = (0..100_000).map(part).sum();
            assert!((mass / 0.06 - 1.0).abs() < 1e-5, "{shape:?}: {mass}");
        }
    }

    #[test]
    fn counted_masses_are_parsed() {
        assert_eq!(counted_masses("mass,count\n2e-3,2\n1e-3,1\n"), Ok(vec![1e-3, 2e-3, 2e-3]));
        assert_eq!(counted_masses("3\n1\n"), Ok(vec![1.0, 3.0]));
        for wrong in ["", "mass\n", "1\nx\n", "1,0\n", "-1\n"] {
            assert!(counted_masses(wrong).is_err(), "{wrong}");
        }
    }
}
