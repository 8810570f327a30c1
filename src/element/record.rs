//! What is followed over increments only because some output asks for it: strains and energies of elements.
//! Never here: anything that stresses or forces need.
#![allow(clippy::needless_range_loop)] // Loops over lanes, as in the inner loop.

use crate::element::block::{Block, Nodes, Workspace};
use crate::kernel::lanes::LANES;
use crate::kernel::lanes::Lanes;
use crate::kernel::lanes::{column, dot};
use crate::kernel::quad::{Gradient, gradient};
use crate::kernel::real::Real;
use crate::kernel::rotation::rotated;
use crate::kernel::stress::mises;
use crate::material::plasticity::Hardening;
use crate::material::volumetric::Volumetric;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::variables::{Part, Variable};

/// Output variables of the eight elements of a block.
#[derive(Clone, Copy, Debug, Default)]
pub struct Record {
    /// Logarithmic strain rr, zz, hoop, rz (tensor component), integrated with the rotation of the stress.
    strain: [Lanes; 4],
    /// Plastic part of it.
    plastic: [Lanes; 4],
    /// Strain rate of the increment behind.
    rate: [Lanes; 4],
    /// Work of the stress, and the part of it that flow has dissipated.
    work: [Lanes; 2],
}

/// What flows in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flows {
    /// Nothing.
    Not,
    /// The deviator, along itself.
    Deviator,
    /// Pressure and deviator: the law tells the plastic strain.
    Coupled,
}

impl Flows {
    /// Of a hardening and a volumetric law.
    pub(super) const fn of<H: Hardening, V: Volumetric>() -> Flows {
        if V::FLOWS {
            Flows::Coupled
        } else if H::PLASTIC {
            Flows::Deviator
        } else {
            Flows::Not
        }
    }
}

/// What a record tells of one element. Tensors as rr, zz, hoop, rz with tensor shear.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Followed {
    /// Logarithmic strain.
    pub strain: [f64; 4],
    /// Plastic strain.
    pub plastic: [f64; 4],
    /// Strain rate, 1/time.
    pub rate: [f64; 4],
    /// Recoverable and dissipated energy.
    pub energy: [f64; 2],
}

impl Followed {
    /// A component of what is followed; of strains the engineering shear, as ABAQUS shows them.
    pub(super) fn value(&self, part: Part) -> Option<f64> {
        let strain = |tensor: [f64; 4]| {
            let component = *tensor.get(part.component)?;
            Some(if part.component == 3 { 2.0 * component } else { component })
        };
        match part.variable {
            Variable::LogarithmicStrain => strain(self.strain),
            Variable::PlasticComponents => strain(self.plastic),
            Variable::StrainRate => strain(self.rate),
            Variable::ElementStrainEnergy => Some(self.energy[0]),
            Variable::ElementPlasticEnergy => Some(self.energy[1]),
            _ => None,
        }
    }
}

/// Gradient operators at the middle of an increment.
#[inline(always)]
pub(super) fn middle(nodes: &Nodes, lane: usize, dt: f64) -> Gradient {
    let place = |x: [f64; 4], v: [f64; 4]| [0, 1, 2, 3].map(|i| x[i] - 0.5 * dt * v[i]);
    gradient(place(nodes.of(lane, 0), nodes.of(lane, 2)), place(nodes.of(lane, 1), nodes.of(lane, 3)))
}

/// Spin increment in the (r, z) plane, as the stress sees it.
#[inline(always)]
pub(super) fn spin(nodes: &Nodes, lane: usize, dt: f64) -> f64 {
    let g = middle(nodes, lane, dt);
    let per = dt / g.volume;
    0.5 * (per * dot(g.z, nodes.of(lane, 2)) - per * dot(g.r, nodes.of(lane, 3)))
}

/// The same of all lanes.
pub(super) fn spins(nodes: &Nodes, dt: f64) -> Lanes {
    std::array::from_fn(|l| spin(nodes, l, dt))
}

impl Record {
    /// Follows an increment, after the stress of its end is known.
    pub(super) fn follow<S, Q, X, T: Real>(
        &mut self,
        block: &Block<S, Q, X, T>,
        flows: Flows,
        spins: &Lanes,
        dt: f64,
        scratch: &Workspace<T>,
    ) {
        let unit = scratch.length * scratch.length * scratch.length;
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        for l in 0..LANES {
            let turn = |x: &[Lanes; 4]| rotated([0, 1, 2, 3].map(|i| x[i][l]), spins[l]);
            let (strain, mut plastic) = (turn(&self.strain), turn(&self.plastic));
            let [increment, carried, stress, deviator] =
                [&scratch.strain, &scratch.carried, &block.stress, &scratch.deviator]
                    .map(|x| column(x, l).map(T::wide));
            let [volume, flow, trial] =
                [unit * scratch.volume[l].wide(), scratch.flow[l].wide(), scratch.trial[l].wide()];
            let doubled = [0, 1, 2, 3].map(|i| increment[i] * (carried[i] + stress[i]));
            self.work[0][l] += 0.5 * volume * ((doubled[0] + doubled[1]) + (doubled[2] + 2.0 * doubled[3]));
            if flows == Flows::Coupled {
                plastic = [0, 1, 2, 3].map(|i| plastic[i] + scratch.back[i][l].wide());
                self.work[1][l] += volume * flow;
            }
            if flows == Flows::Deviator && flow > 0.0 {
                // Associated flow: 3/2 dp s/q, the direction of the trial.
                let per = 1.5 * flow / trial;
                plastic = [0, 1, 2, 3].map(|i| plastic[i] + per * deviator[i]);
                self.work[1][l] += volume * mises(stress) * flow;
            }
            for i in 0..4 {
                self.strain[i][l] = strain[i] + increment[i];
                self.plastic[i][l] = plastic[i];
                self.rate[i][l] = per_dt * increment[i];
            }
        }
    }

    /// What is told of one element.
    pub(super) fn of(&self, lane: usize) -> Followed {
        let tensor = |x: &[Lanes; 4]| [0, 1, 2, 3].map(|i| x[i][lane]);
        let [work, dissipated] = [self.work[0][lane], self.work[1][lane]];
        Followed {
            strain: tensor(&self.strain),
            plastic: tensor(&self.plastic),
            rate: tensor(&self.rate),
            energy: [work - dissipated, dissipated],
        }
    }
}

impl Persist for Record {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Record { strain, plastic, rate, work } = self;
        persist_fields!(archive; strain, plastic, rate, work);
    }
}
