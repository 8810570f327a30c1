//! Elements that fail: what is left of their stress, and those that are deleted, which are masked.
//! Never here: criteria of failure, or of deletion from outside.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other phases.

use super::block::{Block, Nodes, Workspace};
use super::constants::Constants;
use super::eroded::{Eroded, height};
use crate::kernel::lanes::{Corners, LANES, column, wide};
use crate::kernel::real::Real;
use crate::kernel::stress;
use crate::material::failure::{Failure, Seen};
use crate::material::plasticity::Hardening;
use crate::material::volumetric::Volumetric;

impl<T: Real> Workspace<T> {
    /// In place of an element that is gone puts one at rest, whose answers weigh nothing.
    #[inline(always)]
    fn mask_lane(&mut self, nodes: &mut Nodes<T>, l: usize, height: f64) {
        nodes.mask(l, height, self.length);
        if let Some(hourglass) = self.hourglass.get_mut(self.at) {
            hourglass.iter_mut().for_each(|h| h[l] = T::ZERO);
        }
        if let Some(assumed) = self.enhanced.get_mut(self.at) {
            assumed.clear(l);
        }
        self.weight[l] = T::ZERO;
        // Laws are asked for lanes with elements only: what another block left would stay.
        self.flow[l] = T::ZERO;
    }
}

impl<S: Clone, Q: Clone, X: Clone, T: Real> Block<S, Q, X, T> {
    /// Before an increment: in place of elements that were deleted from outside one of their volume at rest, whose answers weigh
    /// nothing.
    #[inline(never)]
    pub(super) fn mask_eroded(&mut self, eroded: &Eroded, nodes: &mut Nodes<T>, scratch: &mut Workspace<T>) {
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            scratch.mask_lane(nodes, l, eroded.height(l));
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
        }
    }

    /// After the increment: neither stress nor forces of such elements. Stress that answers to the whole deformation stayed.
    #[inline(never)]
    pub(super) fn clear_eroded(&mut self, eroded: &Eroded, corners: &mut Corners<T>) {
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
            corners.clear(l);
        }
    }

    /// Before an increment: the stress of the undamaged material, and in place of a deleted element one of its volume at
    /// rest, whose answers weigh nothing.
    #[inline(always)]
    pub(super) fn mask_deleted<F: Failure<State = X>>(
        &mut self,
        failure: &F,
        nodes: &mut Nodes<T>,
        scratch: &mut Workspace<T>,
    ) {
        for l in 0..LANES {
            let share = failure.share(&self.failure, l);
            // A lane behind the last element repeats one that may be gone.
            if share > 0.0 && l < scratch.count {
                let share = T::of(share);
                self.stress.iter_mut().for_each(|s| s[l] = s[l] / share);
                continue;
            }
            scratch.mask_lane(nodes, l, height(failure.volume(&self.failure, l)));
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
        }
    }

    /// After the stress: what failure leaves of it. The work booked becomes that of the stress that acts; the elastic
    /// energy that is lost counts as dissipated.
    #[inline(always)]
    pub(super) fn fail<H: Hardening<State = S>, V: Volumetric<State = Q>, F: Failure<State = X>>(
        &mut self,
        (hardening, volumetric, failure): (&H, &V, &F),
        constants: &Constants,
        dt: f64,
        scratch: &mut Workspace<T>,
    ) {
        let mut seen = Seen {
            plastic: if H::PLASTIC { wide(&scratch.flow) } else { [0.0; LANES] },
            mean: [0.0; LANES],
            mises: [0.0; LANES],
            temperature: [0.0; LANES],
            dt,
            count: scratch.count,
        };
        let mut before = [0.0; LANES];
        for l in 0..LANES {
            let stress = column(&self.stress, l).map(T::wide);
            (seen.mean[l], seen.mises[l]) = (-stress::pressure(stress), stress::mises(stress));
        }
        for l in 0..scratch.count {
            before[l] = failure.share(&self.failure, l);
            let temperature =
                volumetric.temperature(&self.volumetric, l).or_else(|| hardening.temperature(&self.state, l));
            seen.temperature[l] = temperature.unwrap_or(0.0);
        }
        let left = failure.degrade(&mut self.failure, &seen);
        let per_shear = if constants.shear > 0.0 { 1.0 / (6.0 * constants.shear) } else { 0.0 };
        for l in 0..scratch.count {
            if before[l] == 0.0 {
                self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
                continue;
            }
            let (stress, mean, mises) = (column(&self.stress, l).map(T::wide), seen.mean[l], seen.mises[l]);
            let (left, bears) = (left.stress[l], left.mean[l]);
            let shift = [bears - mean, bears - mean, bears - mean, 0.0];
            let (mut work, volume) = (0.0, scratch.volume[l].wide());
            for i in 0..4 {
                let acts = left * (stress[i] + shift[i]);
                let (strain, carried) = (scratch.strain[i][l].wide(), scratch.carried[i][l].wide());
                let booked = carried + stress[i];
                let twice = if i == 3 { 2.0 } else { 1.0 };
                work += twice * strain * (before[l] * carried + acts - booked);
                self.stress[i][l] = T::of(acts);
            }
            scratch.sums.internal[l] += T::of(0.5 * volume * work);
            let bulk = if V::EOS { scratch.bulk[l].wide() } else { constants.bulk };
            let distortion = mises * mises * per_shear;
            let [had, has] = [(before[l], mean), (left, bears)]
                .map(|(share, mean)| share * (distortion + mean * mean / (2.0 * bulk)));
            scratch.sums.plastic[l] += T::of(volume * ((had - has) - (1.0 - left) * mises * seen.plastic[l]));
            scratch.deaths += usize::from(left == 0.0);
        }
    }

    /// Takes the forces of deleted elements away.
    #[inline(always)]
    pub(super) fn clear_deleted<F: Failure<State = X>>(&self, failure: &F, corners: &mut Corners<T>) {
        for l in 0..LANES {
            if failure.share(&self.failure, l) == 0.0 {
                corners.clear(l);
            }
        }
    }
}
