//! Anisotropic yield of Hill (Hill 1948, Proc. R. Soc. A 193, 281; ABAQUS Analysis User's Guide, "Anisotropic
//! yield/creep"), with isotropic hardening. The axes r, z, hoop of the material turn with it.

use super::lane_roots::{LaneStarts, any, lane_roots};
use super::law::{ReturnPoint, StressReturn};
use super::points::ReturnedPoints;
use super::root::{Start, nearby_state};
use crate::kernel::hardening::{LinearTable, TableLine, TableLines};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, put_column};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::rotation::rotate;
use crate::kernel::transcendental::cos_sin_of;
use crate::variables::{Variable, VariableComponent};

/// Metal whose yield stress depends on the direction.
#[derive(Clone, Debug)]
pub struct HillPotential {
    /// Orthonormal directions, without mean stress, of the matrix of the criterion in the normal stresses r, z, hoop.
    directions: [[f64; 3]; 2],
    /// Factors on the squares of the stresses along `directions`, and on twice the square of the shear stress rz.
    /// All are 1.5 for the von Mises stress.
    factors: [f64; 3],
    /// Yield stress of the reference test over plastic strain.
    hardening: LinearTable,
    /// Elastic moduli.
    moduli: ElasticModuli,
}

/// Components of a stress on which the criterion depends: along the two directions, and the shear stress rz.
type Components = [f64; 3];

/// Only state: equivalent plastic strain.
const STRAIN: usize = 0;

impl HillPotential {
    /// Builds the law from the ratios R11, R22, R33, R12 of yield stresses to that of the table (1, 2, 3: r, z, hoop;
    /// R12 to the shear yield stress); `None` if the yield surface is not closed. R13 and R23 have no stress. Equation (20.33).
    pub fn new(ratios: [f64; 4], hardening: LinearTable, moduli: ElasticModuli) -> Option<HillPotential> {
        let [rr, zz, hoop, shear] = ratios.inline_map(|ratio| 1.0 / (ratio * ratio));
        let [f, g, h] = [0.5 * (zz + hoop - rr), 0.5 * (hoop + rr - zz), 0.5 * (rr + zz - hoop)];
        // The matrix [[g + h, -h, -g], [-h, f + h, -f], [-g, -f, f + g]] in the plane of zero mean stress, along
        // (1, -1, 0)/sqrt(2) and (1, 1, -2)/sqrt(6).
        let [across, along, mixed] = [0.5 * (f + g) + 2.0 * h, 1.5 * (f + g), 0.5 * 3.0_f64.sqrt() * (g - f)];
        let half = 0.5 * (across - along);
        let radius = (half * half + mixed * mixed).sqrt();
        let mean = 0.5 * (across + along);
        // Eigenvector of the larger eigenvalue; the form without cancellation.
        let [x, y] = if half >= 0.0 { [half + radius, mixed] } else { [mixed, radius - half] };
        let length = (x * x + y * y).sqrt();
        let [x, y] = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
        let [a, b] = [0.5_f64.sqrt(), 6.0_f64.sqrt().recip()];
        let direction = |x: f64, y: f64| [x * a + y * b, y * b - x * a, -2.0 * y * b];
        let factors = [mean + radius, mean - radius, 1.5 * shear];
        let closed = factors.iter().all(|factor| *factor > 1e-9 && factor.is_finite());
        let directions = [direction(x, y), direction(-y, x)];
        closed.then_some(HillPotential { directions, factors, hardening, moduli })
    }

    /// Returns the equivalent stress of stress components. Equation (20.33).
    #[inline(always)] // Into the return of each point.
    fn equivalent(&self, components: Components) -> f64 {
        let [a, b, shear] = components;
        let [of_a, of_b, of_shear] = self.factors;
        (of_a * a * a + of_b * b * b + 2.0 * of_shear * shear * shear).sqrt()
    }

    /// Returns the trial components reduced by plastic flow. `flow` is 2 G times the plastic multiplier over the
    /// equivalent stress: (1 + flow P) S = S_trial, with P diagonal in these components. Equation (20.34).
    #[inline(always)] // Likewise.
    fn reduced(&self, trial: Components, flow: f64) -> Components {
        let [of_a, of_b, of_shear] = self.factors;
        [trial[0] / (1.0 + flow * of_a), trial[1] / (1.0 + flow * of_b), trial[2] / (1.0 + flow * of_shear)]
    }
}

impl StressReturn for HillPotential {
    fn describe(&self) -> String {
        "Hill anisotropic yield".to_owned()
    }

    fn moduli(&self) -> ElasticModuli {
        self.moduli
    }

    fn initial_state(&self) -> Vec<f64> {
        vec![0.0]
    }

    fn hardening_state(&self) -> Option<usize> {
        Some(STRAIN)
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        (part.variable == Variable::PlasticStrain).then_some(STRAIN)
    }

    /// Equation (20.34).
    fn update(&self, point: &mut ReturnPoint<'_>) {
        let (elastic, rotation) = (point.trial.stress(), cos_sin_of(point.angle));
        let strain_before = point.state[STRAIN];
        let path = self.path(elastic, rotation, (strain_before, self.hardening.line(strain_before)));
        point.stress = elastic;
        point.plastic = [0.0; 4];
        // A NaN is not returned, so that the run halts.
        if !path.is_outside() {
            return;
        }
        let outside = |flow: f64| path.outside::<false>(flow);
        let returned = nearby_state(path.start(), f64::INFINITY, TOLERANCE, outside);
        let (flow, (end, strain_after)) = returned.unwrap_or((f64::INFINITY, ([0.0; 3], f64::NAN)));
        point.state[STRAIN] = strain_after;
        point.plastic = path.plastic(flow, end, rotation);
        for (stress, plastic) in point.stress.iter_mut().zip(point.plastic) {
            *stress -= 2.0 * self.moduli.shear * plastic;
        }
    }
}

/// Values of the yield function, over the yield stress, that are zero.
const TOLERANCE: f64 = 1e-13;

/// Path of the return of a trial stress.
#[derive(Clone, Copy)]
struct HillPath<'a> {
    law: &'a HillPotential,
    trial: Components,
    equivalent: f64,
    strain_before: f64,
    hardening: TableLine<'a>,
}

/// Methods with `LINE` use the line of the table alone, also beyond its end, as loops over lanes need.
impl HillPath<'_> {
    #[inline(always)] // Into the return of each point.
    fn is_outside(&self) -> bool {
        self.equivalent > self.hardening.value * (1.0 + 1e-14)
    }

    /// Returns the yield function over the equivalent stress after flow, with the components and the strain there. Nearly
    /// linear in the flow, also for large increments.
    #[inline(always)] // Likewise.
    fn outside<const LINE: bool>(&self, flow: f64) -> (f64, (Components, f64)) {
        let end = self.law.reduced(self.trial, flow);
        let equivalent = self.law.equivalent(end);
        let strain = self.strain_before + flow * equivalent * (0.5 / self.law.moduli.shear);
        (1.0 - self.hardening.value_at::<LINE>(strain) / equivalent, (end, strain))
    }

    /// Returns where the flow starts.
    #[inline(always)] // Likewise.
    fn start(&self) -> Start {
        // The derivative of the equivalent stress q by the flow is -sum(f² s²)/q.
        let ([of_a, of_b, of_shear], [a, b, shear]) = (self.law.factors, self.trial);
        let squares = (of_a * a) * (of_a * a) + (of_b * b) * (of_b * b);
        let fall = (squares + 2.0 * (of_shear * shear) * (of_shear * shear)) / self.equivalent;
        let rise = self.hardening.slope * self.equivalent * (0.5 / self.law.moduli.shear);
        let first = 1.0 - self.hardening.value / self.equivalent;
        let slope = (rise + (1.0 - first) * fall) / self.equivalent;
        let least = 0.1 * fall / self.equivalent;
        Start { start: 0.0, first, guess: first / if slope > least { slope } else { least } }
    }

    /// Returns the plastic strain after flow, along the global axes. It takes twice the shear modulus times itself from the
    /// stress.
    #[inline(always)] // Likewise.
    fn plastic(&self, flow: f64, end: Components, [cosine, sine]: [f64; 2]) -> [f64; 4] {
        let size = flow * (0.5 / self.law.moduli.shear);
        let [of_a, of_b, shear] = [0, 1, 2].inline_map(|i: usize| size * self.law.factors[i] * end[i]);
        let [a, b] = self.law.directions;
        let [rr, zz, hoop] = [0, 1, 2].inline_map(|i: usize| of_a * a[i] + of_b * b[i]);
        rotate([rr, zz, hoop, shear], [cosine, sine])
    }
}

impl HillPotential {
    /// Returns the path of the return of a stress in a material rotated by an angle with a cosine and a sine.
    #[inline(always)] // Likewise.
    fn path<'a>(
        &'a self,
        stress: [f64; 4],
        [cosine, sine]: [f64; 2],
        (strain_before, hardening): (f64, TableLine<'a>),
    ) -> HillPath<'a> {
        let [rr, zz, hoop, shear] = rotate(stress, [cosine, -sine]);
        let [a, b] = self.directions;
        let trial = [rr * a[0] + zz * a[1] + hoop * a[2], rr * b[0] + zz * b[1] + hoop * b[2], shear];
        HillPath { law: self, trial, equivalent: self.equivalent(trial), strain_before, hardening }
    }

    /// Returns the points of a block to the yield surface. Leaves to the update of a point what ends beyond the line of the
    /// table.
    #[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
    pub(super) fn return_lanes(&self, states: &mut [Lanes], angles: &Lanes, points: &mut ReturnedPoints) {
        let (lines, zero) = (self.hardening.lines(&states[STRAIN]), [0.0; LANES]);
        let (limit, tolerance) = ([f64::INFINITY; LANES], [TOLERANCE; LANES]);
        let mut starts = LaneStarts { start: zero, first: zero, guess: zero, limit, tolerance, open: points.open };
        let (mut trials, mut equivalents, mut rotations) = ([zero; 3], zero, [zero; 2]);
        for l in 0..LANES {
            let rotation = cos_sin_of(angles[l]);
            let path = self.path(points.trial(l).stress(), rotation, (states[STRAIN][l], lines.of(l)));
            let start = path.start();
            (starts.first[l], starts.guess[l]) = (start.first, start.guess);
            starts.open[l] &= u64::from(path.is_outside());
            ([rotations[0][l], rotations[1][l]], equivalents[l]) = (rotation, path.equivalent);
            [trials[0][l], trials[1][l], trials[2][l]] = path.trial;
        }
        points.stay_elastic();
        if !any(&starts.open) {
            return;
        }
        let (strains, mut ends) = (states[STRAIN], zero);
        let paths = HillPaths { strains, lines, trials, equivalents };
        let (flows, failed) = lane_roots(
            &starts,
            #[inline(always)]
            |flows| {
                let mut values = zero;
                for l in 0..LANES {
                    values[l] = paths.of(self, l).outside::<true>(flows[l]).0;
                }
                values
            },
        );
        for l in 0..LANES {
            let path = paths.of(self, l);
            let (_, (end, strain)) = path.outside::<true>(flows[l]);
            let is_returned = starts.open[l] & (1 - failed[l]) & u64::from(path.hardening.holds_at(strain));
            let plastic = path.plastic(flows[l], end, [rotations[0][l], rotations[1][l]]);
            let plastic = plastic.inline_map(|part| if is_returned == 1 { part } else { 0.0 });
            let elastic = column(&points.stress, l);
            let stress = [0, 1, 2, 3].inline_map(|i: usize| elastic[i] - 2.0 * self.moduli.shear * plastic[i]);
            put_column(&mut points.stress, l, stress);
            put_column(&mut points.plastic, l, plastic);
            points.open[l] = starts.open[l] & (1 - is_returned);
            ends[l] = if is_returned == 1 { strain } else { paths.strains[l] };
        }
        states[STRAIN] = ends;
    }
}

/// Paths of the lanes of a block.
struct HillPaths<'a> {
    strains: Lanes,
    lines: TableLines<'a>,
    trials: [Lanes; 3],
    equivalents: Lanes,
}

impl<'a> HillPaths<'a> {
    #[inline(always)] // Likewise.
    fn of(&self, law: &'a HillPotential, l: usize) -> HillPath<'a> {
        let (trial, equivalent) = ([self.trials[0][l], self.trials[1][l], self.trials[2][l]], self.equivalents[l]);
        HillPath { law, trial, equivalent, strain_before: self.strains[l], hardening: self.lines.of(l) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATIOS: [f64; 4] = [1.0, 1.25, 0.9, 1.1];

    fn metal(ratios: [f64; 4], rows: Vec<[f64; 2]>) -> HillPotential {
        HillPotential::new(ratios, LinearTable { rows }, ElasticModuli::from_young(70_000.0, 0.33)).unwrap()
    }

    /// Applies a strain increment at an angle; returns stress, plastic strain and equivalent plastic strain.
    fn strained(law: &HillPotential, strain: [f64; 4], angle: f64) -> ([f64; 4], [f64; 4], f64) {
        let mut state = law.initial_state();
        let mut point = ReturnPoint { angle, ..ReturnPoint::new(strain, [0.0; 4], &mut state, law.moduli) };
        law.update(&mut point);
        let (stress, plastic) = (point.stress, point.plastic);
        (stress, plastic, state[STRAIN])
    }

    /// Returns the criterion as published.
    fn criterion([r1, r2, r3, r12]: [f64; 4], [s1, s2, s3, s12]: [f64; 4]) -> f64 {
        let [r1, r2, r3, r12] = [r1, r2, r3, r12].map(|r| 1.0 / (r * r));
        let square = (r2 + r3 - r1) * (s2 - s3) * (s2 - s3)
            + (r3 + r1 - r2) * (s3 - s1) * (s3 - s1)
            + (r1 + r2 - r3) * (s1 - s2) * (s1 - s2);
        (0.5 * square + 3.0 * r12 * s12 * s12).sqrt()
    }

    /// Sheet with normal anisotropy r: the equibiaxial yield stress is sqrt((1 + r)/2) of the uniaxial one.
    #[test]
    fn equibiaxial_yield_stress_of_a_sheet() {
        let anisotropy = 1.8_f64;
        let thickness = (0.5 * (1.0 + anisotropy)).sqrt();
        let law = metal([1.0, thickness, 1.0, 1.0], vec![[200.0, 0.0]]);
        let [rr, zz, hoop, _] = strained(&law, [0.01, -0.02, 0.01, 0.0], 0.0).0;
        assert!(((rr - zz) / (200.0 * thickness) - 1.0).abs() < 1e-12 && (rr - hoop).abs() < 1e-10);
    }

    /// Increments of all sizes end on the criterion as published, and dissipate the equivalent plastic strain times the
    /// yield stress. A rotated material answers to a rotated strain with the rotated stress.
    #[test]
    fn increments_end_on_the_criterion() {
        let law = metal(RATIOS, vec![[150.0, 0.0], [260.0, 0.08], [300.0, 0.5]]);
        for size in [0.01, 0.3, 40.0] {
            let strain = [0.7, -1.0, 0.2, 0.4].map(|part| part * size);
            let (stress, plastic, equivalent) = strained(&law, strain, 0.0);
            let yields = law.hardening.value(equivalent);
            assert!((criterion(RATIOS, stress) / yields - 1.0).abs() < 1e-9, "{size}");
            let work = super::super::law::contraction(stress, plastic);
            assert!((work / (yields * equivalent) - 1.0).abs() < 1e-7, "{size}");
            let (sine, cosine) = (0.6, 0.8);
            let turned = strained(&law, rotate(strain, [cosine, sine]), libm::atan2(sine, cosine)).0;
            for (a, b) in turned.iter().zip(rotate(stress, [cosine, sine])) {
                assert!((a - b).abs() < 1e-9 * size * 70_000.0, "{a} {b}");
            }
        }
    }

    #[test]
    fn open_yield_surfaces_are_refused() {
        let law = |ratios| HillPotential::new(ratios, LinearTable { rows: vec![[1.0, 0.0]] }, ElasticModuli::default());
        assert!(law([1.0, 1.0, 0.45, 1.0]).is_none() && law([0.4, 1.0, 1.0, 1.0]).is_none());
        assert!(law(RATIOS).is_some_and(|law| law.factors.iter().sum::<f64>() > 0.0));
    }
}
