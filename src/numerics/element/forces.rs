//! Corner forces of a block of elements (stress, bulk viscosity, hourglass control), and the stable time increments.
//! Hourglass control is a spring and a dashpot, or stresses of assumed strains ([`super::enhanced`]).

use pulp::{Simd, WithSimd};

use super::constants::{CHANGE, ElementConstants, damped};
use super::motion::LaneMotion;
use super::shock::{BY_DIRECTION, by_direction, principal_compression};
use super::workspace::{ControlStresses, TaskWorkspace};
use crate::kernel::bulk_viscosity::slow_rate;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, Lanes};
use crate::kernel::pack::{Pack, PackPosition};
use crate::kernel::quad::{QuadOperators, UNIT, at_corners, dot3};
use crate::kernel::real::Real;

/// Largest ratio of the squared frequency of an hourglass pattern to that of the strains. The value 1/4 leaves the
/// stable time increment of undistorted elements unchanged.
const SLOW: f64 = 0.25;

/// Operation that computes the corner forces of a block. The code depends on two properties of a material: whether its
/// moduli vary, and whether it has an equation of state. Materials with the same properties share the compiled code.
pub(super) struct CornerForceUpdate<'a, C, const AREA: bool, const VARY: bool, const EOS: bool> {
    pub stress: &'a [Lanes; 4],
    pub mass: &'a Lanes,
    pub inverse_mass: &'a [Lanes; 4],
    pub constants: &'a ElementConstants,
    pub dt: f64,
    pub kept: &'a mut ControlStresses,
    pub scratch: &'a mut TaskWorkspace,
    pub corners: &'a mut BlockCornerForces,
    pub control: &'a mut C,
}

impl<C: HourglassScheme, const AREA: bool, const VARY: bool, const EOS: bool> WithSimd
    for CornerForceUpdate<'_, C, AREA, VARY, EOS>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let factors = ForceFactors::new::<VARY>((self.constants, self.dt), self.scratch);
        // Roots and divisions take long. While those of a pack are computed, a core begins with the motion of the next
        // pack, which does not depend on them.
        for index in 0..PackPosition::<S>::COUNT {
            let position = PackPosition::new(simd, index);
            let modulus = self.modulus(position);
            let TaskWorkspace { r, z, motion, .. } = &mut *self.scratch;
            motion.measure::<S, AREA>([r, z], self.inverse_mass, modulus, position);
        }
        for index in 0..PackPosition::<S>::COUNT {
            let position = PackPosition::new(simd, index);
            let TaskWorkspace { v_r, v_z, motion, .. } = &*self.scratch;
            let motion = motion.of_pack([v_r, v_z], self.modulus(position), position);
            self.add_pack(&factors, &motion, position);
        }
    }
}

impl<C: HourglassScheme, const AREA: bool, const VARY: bool, const EOS: bool>
    CornerForceUpdate<'_, C, AREA, VARY, EOS>
{
    /// Returns the modulus of longitudinal waves of a pack.
    #[inline(always)]
    fn modulus<S: Simd>(&self, at: PackPosition<S>) -> Pack<S> {
        let [shear43, modulus] = wave(self.constants);
        if VARY { shear43 + at.load(&self.scratch.stress.bulk) } else { at.splat(modulus) }
    }

    /// Computes the corner forces of stress, bulk viscosity and hourglass control, and the stable time increment.
    #[inline(always)]
    fn add_pack<S: Simd>(&mut self, factors: &ForceFactors, lane: &LaneMotion<Pack<S>>, at: PackPosition<S>) {
        let viscosity = self.bulk_viscosity(factors, lane, at);
        let shape = lane.shape;
        let rate = [dot3(shape, lane.along[0]), dot3(shape, lane.along[1])];
        let CornerForceUpdate { control, kept, scratch, inverse_mass, .. } = self;
        let pattern = PatternMotion { at, factors, lane, rate, inverse_mass };
        let control = control.resist::<S, VARY, EOS>(pattern, kept, scratch);
        let stress = self.viscous_stress(&viscosity, at);
        let [along_r, along_z] = corner_forces::<_, AREA>(&lane.g, stress, shape, control);
        self.store_forces(along_r, along_z, at);
        self.add_rate(factors, lane, &viscosity, at);
    }

    /// Stores the corner forces of a pack: the arguments with opposite sign.
    #[inline(always)]
    fn store_forces<S: Simd>(
        &mut self,
        [r0, r1, r2, r3]: [Pack<S>; 4],
        [z0, z1, z2, z3]: [Pack<S>; 4],
        at: PackPosition<S>,
    ) {
        let flat = if AREA { 1.0 / (4.0 * UNIT * at.load(&self.scratch.r[0])) } else { at.splat(1.0) };
        let scaled = |force: Pack<S>| if AREA { flat * -force } else { -force };
        let [first, second, third, fourth] = &mut self.corners;
        at.store_all([scaled(r0), scaled(z0)], first);
        at.store_all([scaled(r1), scaled(z1)], second);
        at.store_all([scaled(r2), scaled(z2)], third);
        at.store_all([scaled(r3), scaled(z3)], fourth);
    }

    /// Returns the bulk viscosity of a pack, and adds its work to the sums. Equation (7.6).
    #[inline(always)]
    fn bulk_viscosity<S: Simd>(
        &mut self,
        factors: &ForceFactors,
        lane: &LaneMotion<Pack<S>>,
        at: PackPosition<S>,
    ) -> LaneViscosity<Pack<S>> {
        let (zero, g) = (at.splat(0.0), &lane.g);
        let (controls, scratch) = (&mut *self.kept, &mut *self.scratch);
        let [along_r, along_z] = lane.along;
        let (modulus, period, quadratic2) = (lane.modulus, lane.period, factors.quadratic2);
        let strain = at.load_all(&scratch.strain.strain);
        let dilation = strain[0] + strain[1] + strain[2];
        let mut dilation_rate = factors.per_dt * dilation;
        if factors.starts {
            dilation_rate = lane.dilation_rate();
        }
        let compression = dilation_rate.if_less(zero, dilation_rate, zero);
        let mut fraction = factors.linear - quadratic2 * 2.0 * period * compression;
        let mut sided = [zero; 4];
        if EOS {
            let rates = if factors.starts {
                let shear = 0.5 * (dot3(g.z, along_r) + dot3(g.r, along_z));
                [dot3(g.r, along_r), dot3(g.z, along_z), shear].inline_map(|sum| sum / g.volume)
            } else {
                [0, 1, 3].inline_map(|i: usize| factors.per_dt * strain[i])
            };
            // The section area is a quarter of the first hoop operator.
            let area = 0.25 * g.hoop[0];
            let length = 0.5 * (area * (at.load(self.mass) * lane.squares)).root() / g.volume;
            let squeezed = principal_compression(rates, -compression);
            fraction = length * (factors.linear + quadratic2 * length * (2.0 * period) * squeezed);
            let viscosity = dilation_rate.if_less(zero, factors.directed * modulus * period * fraction, zero);
            sided = by_direction(rates, dilation_rate, viscosity);
        }
        let mut slow = slow_rate(
            at.load(&controls.slow_dilation),
            dilation_rate,
            factors.dt * lane.omega,
            at.splat(factors.filter),
        );
        if factors.begins {
            slow = lane.dilation_rate();
        }
        at.store(slow, &mut controls.slow_dilation);
        let scale = 2.0 * modulus * period;
        let damping = scale * dilation_rate * fraction - factors.linear * (scale * slow);
        let work = 0.5 * at.load(&scratch.strain.volume) * (at.load(&controls.viscous) + damping) * dilation;
        at.add(work, &mut scratch.sums.viscous);
        if EOS {
            at.store(work - at.load(&scratch.stress.heat), &mut scratch.stress.heat);
            at.add(at.load(&scratch.stress.sheared), &mut scratch.sums.viscous);
        }
        at.store(damping, &mut controls.viscous);
        LaneViscosity { dilation_rate, fraction, damping, sided }
    }

    /// Returns the stress of a pack with its bulk viscosity, in the unit of forces.
    #[inline(always)]
    fn viscous_stress<S: Simd>(&self, viscosity: &LaneViscosity<Pack<S>>, at: PackPosition<S>) -> [Pack<S>; 4] {
        let (stress, LaneViscosity { damping, sided, .. }) = (at.load_all(self.stress), viscosity);
        // The compatible energy update adds the work of viscosity by direction to the heat.
        let viscous = if EOS { [0, 1, 2].inline_map(|i: usize| *damping + sided[i]) } else { [*damping; 3] };
        let [rr, zz, hoop] = [0, 1, 2].inline_map(|i: usize| UNIT * (stress[i] + viscous[i]));
        let rz = UNIT * if EOS { stress[3] + sided[3] } else { stress[3] };
        [rr, zz, hoop, rz]
    }

    /// Updates the largest rate (two over the stable time increment) with that of a pack. With damping 1/dt = ω/2
    /// (sqrt(1 + ξ²) + ξ) (ABAQUS Analysis User's Guide 6.3.3, "Explicit dynamic analysis"); 1 + ξ²/2 replaces the root
    /// and is never smaller. Equations (4.6), (4.9).
    #[inline(always)]
    fn add_rate<S: Simd>(
        &mut self,
        factors: &ForceFactors,
        lane: &LaneMotion<Pack<S>>,
        viscosity: &LaneViscosity<Pack<S>>,
        at: PackPosition<S>,
    ) {
        let (scratch, unity, cap) = (&mut *self.scratch, at.splat(1.0), at.splat(factors.cap));
        let LaneViscosity { dilation_rate, fraction, .. } = *viscosity;
        // In a mode of the whole mesh, bulk viscosity is at most 2 ξ/ω times the stiffness against uniform pressure.
        let share = cap * lane.period;
        let xi = share.if_less(unity, factors.pressing * (fraction * share), fraction);
        // The viscous modulus 4/3 η is 2 ξ/ω times the modulus, and ω² is the modulus times `squares` over V.
        let xi = if EOS { xi + factors.shear_viscosity * lane.squares * lane.per * lane.period } else { xi };
        // The exact root in a cold gas, where ξ has no bound.
        let damped = if VARY { xi + (unity + xi * xi).root() } else { damped(xi) };
        let highest = share.if_less(unity, cap, lane.omega);
        // Two over the increment in which the element would reach the largest allowed volume change.
        let (stable, changing) = (highest * damped, 2.0 / CHANGE * dilation_rate.size());
        if VARY {
            at.store(stable, &mut scratch.own_rate);
        }
        let rate = at.load(&scratch.weight) * stable.if_less(changing, changing, stable);
        let (best, limiting) = (at.load(&scratch.sums.rate), at.load(&scratch.sums.limiting));
        at.store(rate.if_larger_rate(best, rate, best), &mut scratch.sums.rate);
        at.store(rate.if_larger_rate(best, at.splat(scratch.block), limiting), &mut scratch.sums.limiting);
    }
}

/// Factors that are the same for all lanes of a block.
pub(super) struct ForceFactors {
    pub dt: f64,
    /// One over the previous increment; 0 at the start.
    per_dt: f64,
    /// Longitudinal modulus over the bulk modulus.
    pressing: f64,
    /// Linear coefficient of bulk viscosity, and the square of the quadratic one.
    linear: f64,
    quadratic2: f64,
    /// Factor on bulk viscosity by direction.
    directed: f64,
    /// Filter of the rate in the linear term; 0 without.
    filter: f64,
    /// Hourglass control: stiffness, and twice the fraction of critical damping.
    pub stiffness: f64,
    pub viscosity2: f64,
    /// Two thirds of the shear viscosity, in the unit of forces.
    shear_viscosity: f64,
    /// Highest frequency of the model.
    cap: f64,
    /// Whether the analysis starts, so that the rate of volume follows from the current velocities, and so that the slow
    /// part of the rate does.
    starts: bool,
    begins: bool,
}

impl ForceFactors {
    #[inline(always)]
    fn new<const VARY: bool>((constants, dt): (&ElementConstants, f64), scratch: &TaskWorkspace) -> Self {
        let ([_, modulus], viscosity) = (wave(constants), &constants.bulk_viscosity);
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        ForceFactors {
            dt,
            per_dt,
            pressing: modulus / constants.bulk,
            linear: viscosity.linear,
            quadratic2: viscosity.quadratic * viscosity.quadratic,
            directed: if constants.shear == 0.0 { 2.0 * BY_DIRECTION } else { 0.0 },
            filter: viscosity.filter(),
            stiffness: dt * UNIT * constants.hourglass.stiffness * constants.shear,
            viscosity2: 2.0 * constants.hourglass.viscosity,
            shear_viscosity: UNIT * (2.0 / 3.0 * constants.shear_viscosity),
            cap: scratch.cap,
            starts: VARY && per_dt == 0.0,
            begins: viscosity.filters() && per_dt == 0.0,
        }
    }
}

/// Bulk viscosity of a lane.
struct LaneViscosity<T> {
    dilation_rate: T,
    /// Fraction of critical damping.
    fraction: T,
    /// Mean stress of the viscosity.
    damping: T,
    /// Stress of viscosity by direction: rr, zz, hoop, rz.
    sided: [T; 4],
}

/// Returns the forces of stress and hourglass control along r and z at the corners. With area weighting the
/// equation of motion is integrated over the section, including its terms with 1/r; `RingFactors` then scale the nodal
/// forces to full rings. Equations (5.6), (5.14).
#[inline(always)]
fn corner_forces<T: Real, const AREA: bool>(
    g: &QuadOperators<T>,
    [s_rr, s_zz, s_hoop, s_rz]: [T; 4],
    shape: [T; 3],
    PatternForces { pattern: [f_r, f_z], hoop }: PatternForces<T>,
) -> [[T; 4]; 2] {
    let hoop_r = if AREA { s_hoop - s_rr } else { s_hoop };
    let turned = if AREA { -s_rz * g.hoop[0] } else { s_rz.like(0.0) };
    // The operators of hoop strains are those of the gradient, minus the hoop operator along r.
    let (rr_r, rz_r, hoop_r) = match hoop {
        Some([along_r, along_z]) => (s_rr + along_r, s_rz + along_z, hoop_r - along_r),
        None => (s_rr, s_rz, hoop_r),
    };
    let stressed_r = |i: usize| rr_r * g.r[i] + rz_r * g.z[i];
    let stressed_z = |i: usize| s_zz * g.z[i] + s_rz * g.r[i];
    let along_r = at_corners([
        hoop_r * g.hoop[0],
        stressed_r(0) + (hoop_r * g.hoop[1] + f_r * shape[0]),
        stressed_r(1) + (hoop_r * g.hoop[2] + f_r * shape[1]),
        stressed_r(2) + f_r * shape[2],
    ]);
    let along_z = at_corners([
        turned,
        stressed_z(0) + f_z * shape[0],
        stressed_z(1) + f_z * shape[1],
        stressed_z(2) + f_z * shape[2],
    ]);
    [along_r, along_z]
}

/// Returns 4/3 of the shear modulus, and the longitudinal modulus K + 4/3 G.
fn wave(constants: &ElementConstants) -> [f64; 2] {
    let shear43 = 4.0 / 3.0 * constants.shear;
    [shear43, constants.bulk + shear43]
}

/// Type of hourglass resistance of a block.
pub(super) trait HourglassScheme {
    /// Updates the stresses of a pack over an increment, adds their work to the sums, and returns their forces.
    /// `VARY`: the moduli vary; `EOS`: the material has an equation of state.
    fn resist<S: Simd, const VARY: bool, const EOS: bool>(
        &mut self,
        pattern: PatternMotion<'_, S>,
        kept: &mut ControlStresses,
        scratch: &mut TaskWorkspace,
    ) -> PatternForces<Pack<S>>;
}

/// Motion of the hourglass pattern of a pack.
pub(super) struct PatternMotion<'a, S: Simd> {
    pub at: PackPosition<S>,
    pub factors: &'a ForceFactors,
    pub lane: &'a LaneMotion<Pack<S>>,
    /// Products of the pattern with the velocities along r and z.
    pub rate: [Pack<S>; 2],
    pub inverse_mass: &'a [Lanes; 4],
}

/// Generalised forces of hourglass resistance.
pub(super) struct PatternForces<T> {
    /// On the pattern along r and z.
    pub pattern: [T; 2],
    /// On the operators of hoop strains along r and z ([`crate::kernel::assumed::hoop`]); `None` if there are none.
    pub hoop: Option<[T; 2]>,
}

/// Hourglass spring and dashpot.
pub(super) struct PatternSpring;

impl HourglassScheme for PatternSpring {
    /// Computes the hourglass stresses along r and z (Flanagan and Belytschko 1981, eqs. 25 to 45) for the pattern
    /// orthogonal to linear fields. The elastic part may be scaled back with the stress in plastic flow. Equation
    /// (5.8).
    #[inline(always)]
    fn resist<S: Simd, const VARY: bool, const EOS: bool>(
        &mut self,
        PatternMotion { at, factors, lane, rate: [q_r, q_z], .. }: PatternMotion<'_, S>,
        kept: &mut ControlStresses,
        scratch: &mut TaskWorkspace,
    ) -> PatternForces<Pack<S>> {
        let dt = factors.dt;
        let LaneMotion { root, inverse, per, omega, square, .. } = *lane;
        let volume = lane.g.volume;
        // The mass that moves with the pattern, a sixteenth of the element mass for a square, vanishes as an element
        // folds. The stiffness is therefore bounded, so that the pattern's frequency stays below that of the strains,
        // and damping is a fraction of the critical damping.
        let moved = root * (volume * (inverse * (root * volume)));
        let (unbounded, slow_limit) = (factors.stiffness * (4.0 * square) * per, SLOW * dt * omega * moved);
        let spring = unbounded.at_most(slow_limit);
        let dashpot = factors.viscosity2 * moved;
        let ([old_r, old_z], returned) = (at.load_all(&kept.hourglass), at.load(&scratch.stress.returned));
        let (new_r, new_z) = (returned * (old_r + spring * q_r), returned * (old_z + spring * q_z));
        at.store_all([new_r, new_z], &mut kept.hourglass);
        let (drag_r, drag_z) = (dashpot * q_r, dashpot * q_z);
        let power = q_r * (0.5 * (old_r + new_r) + drag_r) + q_z * (0.5 * (old_z + new_z) + drag_z);
        at.add(dt * at.load(&scratch.weight) * power, &mut scratch.sums.artificial);
        PatternForces { pattern: [new_r + drag_r, new_z + drag_z], hoop: None }
    }
}
