//! How surfaces that meet interact: pressure over the closure of the gap, friction over the pressure.
//! Never here: where they meet.

/// Pressure over overclosure (ABAQUS Analysis User's Guide, "Contact pressure-overclosure relationships").
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Overclosure {
    /// Surfaces never overlap, whatever the pressure.
    #[default]
    Hard,
    /// Pressure a length of overlap.
    Linear(f64),
    /// The same of a penalty spring, which presses as at the overlap in the middle of an increment.
    Spring(f64),
    /// Pressure at no gap, and the gap at which it begins:
    /// p = p0/(e - 1) ((h/c + 1)(exp(h/c + 1) - 1)) for overlaps h above -c.
    Exponential([f64; 2]),
    /// Rows of pressure and overlap, ascending; the last slope goes on.
    Table(Vec<[f64; 2]>),
}

impl Overclosure {
    /// The part of the increment behind which the overlap counts. At its end no slope limits the increment and what oscillates on
    /// it is damped most; the middle is the earliest at which none does: x(n+1) - 2 x(n) + x(n-1) = -s ((1 - t) x(n) + t x(n+1)) has
    /// no growing root where (1 - 2 t) s <= 4.
    pub fn look_ahead(&self) -> f64 {
        if matches!(self, Overclosure::Spring(_)) { 0.5 } else { 1.0 }
    }

    /// The gap at which pressure begins.
    pub fn begins(&self) -> f64 {
        match self {
            Overclosure::Hard | Overclosure::Linear(_) | Overclosure::Spring(_) => 0.0,
            Overclosure::Exponential([_, gap]) => *gap,
            Overclosure::Table(rows) => rows.first().map_or(0.0, |row| -row[1]),
        }
    }

    /// A straight line near an overlap, by its value there and its slope, which is never zero: the tangent, and where nothing
    /// presses the line along which pressure begins, gone on with below zero.
    pub fn line(&self, overlap: f64) -> [f64; 2] {
        let tangent = self.pressure(overlap);
        if tangent[1] > 0.0 {
            return tangent;
        }
        let slope = match self {
            Overclosure::Hard => return tangent,
            Overclosure::Linear(stiffness) | Overclosure::Spring(stiffness) => *stiffness,
            Overclosure::Exponential([at_zero, gap]) => at_zero / gap,
            Overclosure::Table(rows) => match rows[..] {
                [first, second, ..] => (second[0] - first[0]) / (second[1] - first[1]),
                _ => return tangent,
            },
        };
        [slope * (overlap + self.begins()), slope]
    }

    /// Pressure at an overlap, and how fast it grows.
    pub fn pressure(&self, overlap: f64) -> [f64; 2] {
        match self {
            Overclosure::Hard => [0.0, 0.0],
            Overclosure::Linear(stiffness) | Overclosure::Spring(stiffness) if overlap > 0.0 => {
                [stiffness * overlap, *stiffness]
            }
            Overclosure::Linear(_) | Overclosure::Spring(_) => [0.0, 0.0],
            Overclosure::Exponential([at_zero, gap]) => {
                let x = overlap / gap + 1.0;
                if x <= 0.0 {
                    return [0.0, 0.0];
                }
                let (factor, grown) = (at_zero / (std::f64::consts::E - 1.0), libm::exp(x));
                [factor * x * (grown - 1.0), factor * (grown - 1.0 + x * grown) / gap]
            }
            Overclosure::Table(rows) => tabulated(rows, overlap),
        }
    }
}

fn tabulated(rows: &[[f64; 2]], overlap: f64) -> [f64; 2] {
    let [Some(first), Some(_)] = [rows.first(), rows.get(1)] else { return [0.0, 0.0] };
    if overlap <= first[1] {
        return [0.0, 0.0];
    }
    let next = rows.partition_point(|row| row[1] < overlap).clamp(1, rows.len() - 1);
    let ([p, h], [q, k]) = (rows[next - 1], rows[next]);
    let slope = (q - p) / (k - h);
    [p + slope * (overlap - h), slope]
}

/// Coulomb friction, with a coefficient that may decay with the rate of slip (ABAQUS Analysis User's Guide, "Frictional
/// behavior").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Coefficient at rest, or at any rate.
    pub at_rest: f64,
    /// Coefficient at great rates of slip.
    pub sliding: f64,
    /// How fast one becomes the other, time a length.
    pub decay: f64,
    /// The largest shear stress (`TAUMAX`).
    pub largest: f64,
}

impl Default for Friction {
    fn default() -> Self {
        Friction::of(0.0)
    }
}

impl Friction {
    /// One coefficient.
    pub fn of(coefficient: f64) -> Friction {
        Friction { at_rest: coefficient, sliding: coefficient, decay: 0.0, largest: f64::INFINITY }
    }

    /// Whether there is any.
    pub fn is_there(&self) -> bool {
        self.at_rest > 0.0 || self.sliding > 0.0
    }

    /// The coefficient at a rate of slip.
    pub fn coefficient(&self, rate: f64) -> f64 {
        if self.decay == 0.0 {
            return self.at_rest;
        }
        self.sliding + (self.at_rest - self.sliding) * libm::exp(-self.decay * rate)
    }
}

/// How two surfaces interact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Law {
    /// Along the normal.
    pub overclosure: Overclosure,
    /// Along the surface.
    pub friction: Friction,
    /// Of heat.
    pub heat: GapHeat,
}

/// Heat where surfaces meet (ABAQUS Analysis User's Guide, "Thermal contact properties").
#[derive(Clone, Debug, PartialEq)]
pub struct GapHeat {
    /// Rows of the conductance, heat a time, area and temperature, and the clearance, ascending; none beyond the last.
    pub over_clearance: Vec<[f64; 2]>,
    /// The same over the pressure, of surfaces that press; the last row goes on.
    pub over_pressure: Vec<[f64; 2]>,
    /// Part of the work of friction that becomes heat.
    pub fraction: f64,
    /// Part of that which goes to the first surface.
    pub to_first: f64,
}

impl Default for GapHeat {
    fn default() -> Self {
        GapHeat { over_clearance: Vec::new(), over_pressure: Vec::new(), fraction: 1.0, to_first: 0.5 }
    }
}

impl GapHeat {
    /// Conductance across a gap at a pressure.
    pub fn conductance(&self, gap: f64, pressure: f64) -> f64 {
        if pressure > 0.0 && !self.over_pressure.is_empty() {
            return between(&self.over_pressure, pressure);
        }
        match self.over_clearance.last() {
            Some(last) if gap <= last[1] => between(&self.over_clearance, gap),
            _ => 0.0,
        }
    }

    /// The largest conductance there can be.
    pub fn most(&self) -> f64 {
        self.over_clearance.iter().chain(&self.over_pressure).map(|row| row[0]).fold(0.0, f64::max)
    }
}

/// Rows of a value and its argument, which ascends; the first and the last go on.
fn between(rows: &[[f64; 2]], at: f64) -> f64 {
    let next = rows.partition_point(|row| row[1] < at);
    match (next.checked_sub(1).map(|i| rows[i]), rows.get(next)) {
        (Some([k, x]), Some([l, y])) => k + (l - k) * (at - x) / (y - x),
        (Some([k, _]), None) => k,
        (None, first) => first.map_or(0.0, |row| row[0]),
    }
}

#[cfg(test)]
mod tests {
    use super::GapHeat;

    /// Between rows by their line, before the first as there, behind the last none over the clearance and as there over the
    /// pressure, which counts where surfaces press.
    #[test]
    fn conductance_follows_its_rows() {
        let over_clearance = vec![[4.0, 0.0], [2.0, 0.1], [1.0, 0.3]];
        let open = GapHeat { over_clearance, ..GapHeat::default() };
        for (gap, expected) in [(-1.0, 4.0), (0.0, 4.0), (0.05, 3.0), (0.1, 2.0), (0.2, 1.5), (0.3, 1.0), (0.31, 0.0)] {
            assert!((open.conductance(gap, 0.0) - expected).abs() < 1e-15, "{gap}");
            assert_eq!(open.conductance(gap, 5.0), open.conductance(gap, 0.0));
        }
        let both = GapHeat { over_pressure: vec![[5.0, 0.0], [9.0, 2.0]], ..open };
        assert_eq!([0.0, 1.0, 9.0].map(|p| both.conductance(0.0, p)), [4.0, 7.0, 9.0]);
        assert_eq!(both.most(), 9.0);
    }
}
