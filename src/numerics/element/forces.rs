//! Corner forces of a block of elements (stress, bulk viscosity, hourglass control), and the stable time increments.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use pulp::NullaryFnOnce;

use super::block::{HourglassState, TaskWorkspace, is_larger};
use super::constants::{CHANGE, ElementConstants, damped};
use super::control::{HourglassScheme, LaneKinematics};
use super::shock::{BY_DIRECTION, by_direction, principal_compression};
use crate::kernel::bulk_viscosity::slow_rate;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, column};
use crate::kernel::quad::{QuadOperators, UNIT, at_corners, dot3, squares};
use crate::kernel::real::Real;
use crate::material::increment::StressUpdate;

/// Largest ratio of the squared frequency of an hourglass pattern to that of the strains. The value 1/4 leaves the
/// stable time increment of undistorted elements unchanged.
const SLOW: f64 = 0.25;

/// Operation that computes the corner forces of a block. The code depends on two properties of a material: whether its
/// moduli vary, and whether it has an equation of state. Materials with the same properties share the compiled code.
pub(super) struct CornerForceUpdate<'a, C, T, const AREA: bool, const VARY: bool, const EOS: bool> {
    pub stress: &'a [Lanes<T>; 4],
    pub mass: &'a Lanes<T>,
    pub inverse_mass: &'a [Lanes<T>; 4],
    pub constants: &'a ElementConstants,
    pub dt: T,
    pub kept: &'a mut HourglassState<T>,
    pub scratch: &'a mut TaskWorkspace<T>,
    pub corners: &'a mut BlockCornerForces<T>,
    pub control: &'a mut C,
}

impl<C: HourglassScheme<T>, T: Real, const AREA: bool, const VARY: bool, const EOS: bool> NullaryFnOnce
    for CornerForceUpdate<'_, C, T, AREA, VARY, EOS>
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let CornerForceUpdate { stress, mass, inverse_mass, constants, dt, kept, scratch, corners, control } = self;
        let block = BlockMaterial::<T, AREA, VARY, EOS> { stress, mass, inverse_mass };
        block.forces((constants, dt), kept, scratch, corners, control);
    }
}

/// Stresses and masses of a block.
struct BlockMaterial<'a, T, const AREA: bool, const VARY: bool, const EOS: bool> {
    stress: &'a [Lanes<T>; 4],
    mass: &'a Lanes<T>,
    inverse_mass: &'a [Lanes<T>; 4],
}

impl<T: Real, const AREA: bool, const VARY: bool, const EOS: bool> BlockMaterial<'_, T, AREA, VARY, EOS> {
    /// Computes the operators, the bound of the highest frequency and the hourglass pattern in the current
    /// configuration. Divisions and roots end a loop body, so that later lanes do not wait for their results.
    #[inline(always)]
    fn measure_now(&self, constants: &ElementConstants, scratch: &mut TaskWorkspace<T>) {
        let [shear43, modulus] = wave(constants);
        let unit = T::of(UNIT);
        let TaskWorkspace { r, z, now, stress: StressUpdate { bulk, .. }, inverse, .. } = scratch;
        for l in 0..LANES {
            let modulus = if VARY { bulk[l] + shear43 } else { modulus };
            let (r, z, inverse_mass) = (column(r, l), column(z, l), column(self.inverse_mass, l));
            let g = QuadOperators::of::<AREA>(r, z);
            // ω² ≤ c_d² ρ V Σ (b_r² + b_z² + b_θ²)/m; this is the sum.
            let lists = [
                [T::ZERO, g.r[0], g.r[1], g.r[2]],
                [T::ZERO, g.z[0], g.z[1], g.z[2]],
                [g.hoop[0], g.hoop[1], g.hoop[2], T::ZERO],
            ];
            let all = squares(&lists, inverse_mass);
            let pattern = g.pattern([r[3], z[3]]);
            for i in 0..3 {
                now.r[i][l] = g.r[i];
                now.z[i][l] = g.z[i];
                now.hoop[i][l] = g.hoop[i];
                now.pattern[i][l] = pattern[i];
            }
            now.volume[l] = g.volume;
            now.squares[l] = all;
            now.light[l] = squares(&[[T::ZERO, pattern[0], pattern[1], pattern[2]]], inverse_mass);
            now.root[l] = (modulus * unit * all * g.volume).root();
        }
        for l in 0..LANES {
            inverse[l] = T::ONE / (now.volume[l] * (now.root[l] * now.light[l]));
        }
    }

    /// Computes the corner forces of stress, bulk viscosity and hourglass control, and the stable time increment.
    #[inline(always)]
    fn forces<C: HourglassScheme<T>>(
        &self,
        (constants, dt): (&ElementConstants, T),
        kept: &mut HourglassState<T>,
        scratch: &mut TaskWorkspace<T>,
        corners: &mut BlockCornerForces<T>,
        control: &mut C,
    ) {
        let factors = ForceFactors::new::<VARY>((constants, dt), scratch);
        self.measure_now(constants, scratch);
        for l in 0..LANES {
            let lane = self.lane_motion(&factors, scratch, l);
            let viscosity = self.bulk_viscosity(&factors, &lane, (kept, scratch), l);
            let shape = scratch.now.pattern(l).inline_map(|part| lane.per * part);
            let rate = [dot3(shape, lane.along[0]), dot3(shape, lane.along[1])];
            let mut hourglass = [T::ZERO; 2];
            if C::ENHANCED {
                let (v_r, squares) = (lane.v_r, lane.squares);
                control.store_lane(l, &LaneKinematics { g: &lane.g, per: lane.per, shape, rate, v_r, squares });
            } else {
                hourglass = hourglass_stress(&factors, &lane, rate, (kept, scratch), l);
            }
            let stress = self.viscous_stress(&viscosity, l);
            let [along_r, along_z] = corner_forces::<T, AREA>(&lane.g, stress, shape, hourglass);
            let flat = if AREA { T::ONE / (T::of(4.0) * factors.unit * scratch.r[0][l]) } else { T::ONE };
            for i in 0..4 {
                let forces = [along_r[i], along_z[i]].inline_map(|f| if T::SINGLE { factors.against * f } else { -f });
                corners.0[i][l] = if AREA { forces.inline_map(|force| flat * force) } else { forces };
            }
            scratch.add_rate::<VARY, EOS>(&factors, &lane, &viscosity, l);
        }
    }

    /// Returns geometry and motion of a lane.
    #[inline(always)]
    fn lane_motion(&self, factors: &ForceFactors<T>, scratch: &TaskWorkspace<T>, l: usize) -> LaneMotion<T> {
        let modulus = if VARY { scratch.stress.bulk[l] + factors.shear43 } else { factors.modulus };
        let (v_r, [_, w1, w2, w3]) = (column(&scratch.v_r, l), column(&scratch.v_z, l));
        let now = &scratch.now;
        let (g, inverse_mass, squares) = (now.operators(l), column(self.inverse_mass, l), now.squares[l]);
        // ω = root / V. One division yields 1/V, 1/ω and the mass that moves with the pattern.
        let (root, light, inverse) = (now.root[l], now.light[l], scratch.inverse[l]);
        let inverse_root = inverse * (g.volume * light);
        let per = inverse * (root * light);
        let square = dot3(g.r, g.r) + dot3(g.z, g.z);
        // Bulk viscosity (ABAQUS Analysis User's Guide, "Explicit dynamic analysis"); it is not part of the stored
        // stress. The length is 2 c/ω, so that the linear coefficient is the fraction of critical damping in the
        // highest mode, also in flat elements: ρ c times the length is then 2 (K + 4/3 G)/ω.
        let mut period = g.volume * inverse_root;
        if AREA {
            // From the plane section only: the hoop term would disturb spherical symmetry.
            period = g.volume / (modulus * factors.unit * square * inverse_mass[0] * g.volume).root();
        }
        let along = [[v_r[1], v_r[2], v_r[3]], [w1, w2, w3]];
        LaneMotion { g, v_r, along, modulus, squares, square, root, inverse, per, omega: root * per, period }
    }

    /// Returns the bulk viscosity of a lane, and adds its work to the sums.
    #[inline(always)]
    fn bulk_viscosity(
        &self,
        factors: &ForceFactors<T>,
        lane: &LaneMotion<T>,
        (kept, scratch): (&mut HourglassState<T>, &mut TaskWorkspace<T>),
        l: usize,
    ) -> LaneViscosity<T> {
        let (zero, half, two, g) = (T::ZERO, T::of(0.5), T::of(2.0), &lane.g);
        let ([along_r, along_z], ring) = (lane.along, [lane.v_r[0], lane.v_r[1], lane.v_r[2]]);
        let (modulus, period, quadratic2) = (lane.modulus, lane.period, factors.quadratic2);
        let dilation = scratch.strain.strain[0][l] + scratch.strain.strain[1][l] + scratch.strain.strain[2][l];
        let mut dilation_rate = dilation * factors.per_dt;
        let current_rate = || (dot3(g.r, along_r) + dot3(g.z, along_z) + dot3(g.hoop, ring)) / g.volume;
        if factors.starts {
            dilation_rate = current_rate();
        }
        let compression = if dilation_rate < zero { dilation_rate } else { zero };
        let mut fraction = factors.linear - quadratic2 * two * period * compression;
        let mut sided = [zero; 4];
        if EOS {
            let rates = if factors.starts {
                let shear = half * (dot3(g.z, along_r) + dot3(g.r, along_z));
                [dot3(g.r, along_r), dot3(g.z, along_z), shear].inline_map(|sum| sum / g.volume)
            } else {
                [0, 1, 3].inline_map(|i: usize| scratch.strain.strain[i][l] * factors.per_dt)
            };
            // The section area is a quarter of the first hoop operator.
            let length = half * (T::of(0.25) * g.hoop[0] * (self.mass[l] * lane.squares)).root() / g.volume;
            let squeezed = principal_compression(rates, -compression);
            fraction = length * (factors.linear + quadratic2 * length * two * period * squeezed);
            let viscosity = if dilation_rate < zero { factors.directed * modulus * period * fraction } else { zero };
            sided = by_direction(rates, dilation_rate, viscosity);
        }
        let mut slow = slow_rate(kept.slow_dilation[l], dilation_rate, factors.dt * lane.omega, factors.filter);
        if factors.filter > zero && factors.per_dt == zero {
            slow = current_rate();
        }
        kept.slow_dilation[l] = slow;
        let scale = two * modulus * period;
        let damping = scale * dilation_rate * fraction - scale * slow * factors.linear;
        let work = scratch.strain.volume[l] * half * (kept.viscous[l] + damping) * dilation;
        scratch.sums.viscous[l] += work;
        if EOS {
            scratch.stress.heat[l] = work - scratch.stress.heat[l];
            scratch.sums.viscous[l] += scratch.stress.sheared[l];
        }
        kept.viscous[l] = damping;
        LaneViscosity { dilation_rate, fraction, damping, sided }
    }

    /// Returns the stress of a lane with its bulk viscosity, in the unit of forces.
    #[inline(always)]
    fn viscous_stress(&self, viscosity: &LaneViscosity<T>, l: usize) -> [T; 4] {
        let (unit, LaneViscosity { damping, sided, .. }) = (T::of(UNIT), viscosity);
        // The compatible energy update adds the work of viscosity by direction to the heat.
        let viscous = if EOS { [0, 1, 2].inline_map(|i: usize| *damping + sided[i]) } else { [*damping; 3] };
        let [rr, zz, hoop] = [0, 1, 2].inline_map(|i: usize| unit * (self.stress[i][l] + viscous[i]));
        let rz = unit * if EOS { self.stress[3][l] + sided[3] } else { self.stress[3][l] };
        [rr, zz, hoop, rz]
    }
}

/// Factors that are the same for all lanes of a block. They are copies: reads from the scratch memory that the loop
/// writes would prevent vectorization.
struct ForceFactors<T> {
    dt: T,
    /// One over the previous increment; 0 at the start.
    per_dt: T,
    unit: T,
    /// Minus the unit of forces, which is that of areas.
    against: T,
    shear43: T,
    modulus: T,
    /// Longitudinal modulus over the bulk modulus.
    pressing: T,
    /// Linear coefficient of bulk viscosity, and the square of the quadratic one.
    linear: T,
    quadratic2: T,
    /// Factor on bulk viscosity by direction.
    directed: T,
    /// Filter of the rate in the linear term; 0 without.
    filter: T,
    /// Hourglass control: stiffness, twice the fraction of critical damping, largest squared frequency ratio.
    stiffness: T,
    viscosity2: T,
    slow: T,
    /// Two thirds of the shear viscosity, in the units of lengths and forces.
    shear_viscosity: T,
    /// Highest frequency of the model, and index of the block.
    cap: T,
    block: T,
    /// Whether the analysis starts, so that the rate of volume follows from the current velocities.
    starts: bool,
}

impl<T: Real> ForceFactors<T> {
    #[inline(always)]
    fn new<const VARY: bool>((constants, dt): (&ElementConstants, T), scratch: &TaskWorkspace<T>) -> Self {
        let [shear43, modulus] = wave::<T>(constants);
        let [linear, quadratic] =
            [constants.bulk_viscosity.linear, constants.bulk_viscosity.quadratic].inline_map(T::of);
        let per_dt = if dt > T::ZERO { T::ONE / dt } else { T::ZERO };
        let unit = T::of(UNIT);
        ForceFactors {
            dt,
            per_dt,
            unit,
            against: T::of(-scratch.length * scratch.length),
            shear43,
            modulus,
            pressing: modulus / T::of(constants.bulk),
            linear,
            quadratic2: quadratic * quadratic,
            directed: T::of(if constants.shear == 0.0 { 2.0 * BY_DIRECTION } else { 0.0 }),
            filter: T::of(constants.bulk_viscosity.filter()),
            stiffness: dt * unit * T::of(constants.hourglass.stiffness) * T::of(constants.shear),
            viscosity2: T::of(2.0 * constants.hourglass.viscosity),
            slow: T::of(SLOW),
            shear_viscosity: unit * T::of(2.0 / 3.0 * constants.shear_viscosity / scratch.length),
            cap: scratch.cap,
            block: scratch.block,
            starts: VARY && per_dt == T::ZERO,
        }
    }
}

/// Geometry and motion of a lane.
struct LaneMotion<T> {
    g: QuadOperators<T>,
    /// Velocities along r, combined by [`sums`](crate::kernel::quad::sums).
    v_r: [T; 4],
    /// Combined velocities along r and z without the mean.
    along: [[T; 3]; 2],
    /// Modulus of longitudinal waves.
    modulus: T,
    /// Sum of the squares of all operators over the corner masses, and the sum of squares without the hoop operator.
    squares: T,
    square: T,
    /// Highest frequency times the volume, and a common inverse: 1/V and 1/ω follow from it without another division.
    root: T,
    inverse: T,
    /// One over the volume.
    per: T,
    omega: T,
    /// One over the frequency that bulk viscosity damps.
    period: T,
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

/// Returns the hourglass stresses of a lane along r and z (Flanagan and Belytschko 1981, eqs. 25 to 45) for the pattern
/// orthogonal to linear fields. The elastic part may be scaled back with the stress in plastic flow.
#[inline(always)]
fn hourglass_stress<T: Real>(
    factors: &ForceFactors<T>,
    lane: &LaneMotion<T>,
    [q_r, q_z]: [T; 2],
    (kept, scratch): (&mut HourglassState<T>, &mut TaskWorkspace<T>),
    l: usize,
) -> [T; 2] {
    let (half, four, dt) = (T::of(0.5), T::of(4.0), factors.dt);
    let LaneMotion { root, inverse, per, omega, square, .. } = *lane;
    let volume = lane.g.volume;
    // The mass that moves with the pattern, a sixteenth of the element mass for a square, vanishes as an element folds.
    // The stiffness is therefore bounded, so that the pattern's frequency stays below that of the strains, and damping
    // is a fraction of the critical damping.
    let moved = root * (volume * (inverse * (root * volume)));
    let (unbounded, most) = (factors.stiffness * (four * square) * per, factors.slow * dt * omega * moved);
    let spring = if unbounded < most { unbounded } else { most };
    let dashpot = factors.viscosity2 * moved;
    let (old_r, old_z) = (kept.hourglass[0][l], kept.hourglass[1][l]);
    let left = scratch.stress.returned[l];
    let (new_r, new_z) = (left * (old_r + spring * q_r), left * (old_z + spring * q_z));
    kept.hourglass[0][l] = new_r;
    kept.hourglass[1][l] = new_z;
    let (drag_r, drag_z) = (dashpot * q_r, dashpot * q_z);
    let power = q_r * (half * (old_r + new_r) + drag_r) + q_z * (half * (old_z + new_z) + drag_z);
    scratch.sums.artificial[l] += dt * scratch.weight[l] * power;
    [new_r + drag_r, new_z + drag_z]
}

/// Returns the forces of stress and hourglass control along r and z at the corners of a lane. With area weighting the
/// equation of motion is integrated over the section, including its terms with 1/r; `RingFactors` then scale the nodal
/// forces to full rings.
#[inline(always)]
fn corner_forces<T: Real, const AREA: bool>(
    g: &QuadOperators<T>,
    [s_rr, s_zz, s_hoop, s_rz]: [T; 4],
    shape: [T; 3],
    [f_r, f_z]: [T; 2],
) -> [[T; 4]; 2] {
    let (hoop_r, hoop_z) = if AREA { (s_hoop - s_rr, -s_rz) } else { (s_hoop, T::ZERO) };
    let stressed_r = |i: usize| s_rr * g.r[i] + s_rz * g.z[i];
    let stressed_z = |i: usize| s_zz * g.z[i] + s_rz * g.r[i];
    let along_r = at_corners([
        hoop_r * g.hoop[0],
        stressed_r(0) + (hoop_r * g.hoop[1] + f_r * shape[0]),
        stressed_r(1) + (hoop_r * g.hoop[2] + f_r * shape[1]),
        stressed_r(2) + f_r * shape[2],
    ]);
    let along_z = at_corners([
        hoop_z * g.hoop[0],
        stressed_z(0) + f_z * shape[0],
        stressed_z(1) + f_z * shape[1],
        stressed_z(2) + f_z * shape[2],
    ]);
    [along_r, along_z]
}

/// Returns 4/3 of the shear modulus, and the longitudinal modulus K + 4/3 G.
fn wave<T: Real>(constants: &ElementConstants) -> [T; 2] {
    let shear43 = 4.0 / 3.0 * constants.shear;
    [shear43, constants.bulk + shear43].inline_map(T::of)
}

impl<T: Real> TaskWorkspace<T> {
    /// Updates the largest rate (two over the stable time increment) with that of a lane. With damping 1/dt = ω/2
    /// (sqrt(1 + ξ²) + ξ) (ABAQUS Analysis User's Guide 6.3.3, "Explicit dynamic analysis"); 1 + ξ²/2 replaces the root
    /// and is never smaller.
    #[inline(always)]
    fn add_rate<const VARY: bool, const EOS: bool>(
        &mut self,
        factors: &ForceFactors<T>,
        lane: &LaneMotion<T>,
        viscosity: &LaneViscosity<T>,
        l: usize,
    ) {
        let LaneViscosity { dilation_rate, fraction, .. } = *viscosity;
        // In a mode of the whole mesh, bulk viscosity is at most 2 ξ/ω times the stiffness against uniform pressure.
        let share = factors.cap * lane.period;
        let capped = share < T::ONE;
        let xi = if capped { fraction * share * factors.pressing } else { fraction };
        // The viscous modulus 4/3 η is 2 ξ/ω times the modulus, and ω² is the modulus times `squares` over V.
        let xi = if EOS { xi + factors.shear_viscosity * lane.squares * lane.per * lane.period } else { xi };
        // The exact root in a cold gas, where ξ has no bound.
        let damped = if VARY { xi + (T::ONE + xi * xi).root() } else { damped(xi) };
        let highest = if capped { factors.cap } else { lane.omega };
        // Two over the increment in which the element would reach the largest allowed volume change.
        let (stable, changing) = (highest * damped, dilation_rate.size() * T::of(2.0 / CHANGE));
        if VARY {
            self.own_rate[l] = stable;
        }
        let rate = self.weight[l] * if changing > stable { changing } else { stable };
        // NaN counts as the largest, so that the error is found.
        let (best, limiting) = (self.sums.rate[l], self.sums.limiting[l]);
        let larger = is_larger(rate, best);
        self.sums.rate[l] = if larger { rate } else { best };
        self.sums.limiting[l] = if larger { factors.block } else { limiting };
    }
}
