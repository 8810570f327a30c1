//! A pressure given by the user's routine (`PNU` and its kin).
//! Never here: how the routine was made or loaded.

use crate::load::Account;
use crate::load::FacetFields;
use crate::load::Force;
use crate::load::Slot;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::state::{BodyState, Instant};
use crate::user::{LoadFailure, LoadPoints, MAX_BLOCK, SharedLoad};

/// What is the same for all facets of a load.
pub struct UserLoad {
    /// What asked for it.
    pub cause: EffectId,
    /// Surface or element set, upper case.
    pub name: String,
    /// `jltyp`.
    pub load_type: i32,
    /// Whether the routine is shown normals that point into the body, as solids have it.
    pub inward: bool,
    /// Magnitude and amplitude; the routine applies them.
    pub magnitude: Magnitude,
    /// The routine.
    pub routine: SharedLoad,
}

/// A load integration point.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Element index.
    pub element: usize,
    /// `[r, z]` at the start.
    pub place: [f64; 2],
    /// Outward unit normal, zero for a body force.
    pub normal: [f64; 2],
    /// Force along z for a value of one: minus area times n_z, or the volume.
    pub weight: f64,
}

/// Load integration points of one body, in blocks as the routine is shown them.
pub struct UserPressure {
    load: UserLoad,
    body: usize,
    blocks: Vec<Block>,
    /// Whether displacements and accelerations are kept up too.
    shows_motion: bool,
}

/// At most [`MAX_BLOCK`] points.
struct Block {
    elements: Vec<usize>,
    weight: Vec<f64>,
    z_start: Vec<f64>,
    shown: Shown,
    /// Pressures of the evaluation before: what frames show if the routine fails now.
    pressure_before: Vec<f64>,
}

/// The arrays of one call, for at most [`MAX_BLOCK`] points; what they hold is said at [`LoadPoints`].
pub struct Shown {
    count: usize,
    /// r of all points, z of all points, and NaN.
    pub coordinates: Vec<f64>,
    /// Slabs of velocity, displacement and acceleration.
    pub motion: Vec<f64>,
    directions: Vec<f64>,
    normal_r: Vec<f64>,
    normal_z: Vec<f64>,
    /// Room for a whole block, and one behind it: a routine that writes past its points is found out.
    pressure: Vec<f64>,
}

/// A NaN that is noticed wherever it is used, even in a comparison: what lies behind two coordinates.
const SIGNALLING: u64 = 0x7ff4_0000_0000_0000;

impl Shown {
    /// Arrays for so many points, without values.
    pub fn new(count: usize) -> Self {
        let slabs = |slabs: usize, value: f64| vec![value; slabs * count];
        let no_number = f64::from_bits(SIGNALLING);
        Shown {
            count,
            coordinates: slabs(3, no_number),
            motion: slabs(6, 0.0),
            directions: slabs(9, no_number),
            normal_r: slabs(1, 0.0),
            normal_z: slabs(1, 0.0),
            pressure: vec![f64::NAN; MAX_BLOCK + 1],
        }
    }

    /// Sets the outward normal of a point, and with it the directions: the normal as the routine is shown it, and that
    /// turned counter-clockwise, by which (n_r, n_z) becomes (-n_z, n_r).
    pub fn set_normal(&mut self, point: usize, [r, z]: [f64; 2], inward: bool) {
        (self.normal_r[point], self.normal_z[point]) = (r, z);
        let sign = if inward { -1.0 } else { 1.0 };
        for (slab, value) in [sign * r, -sign * z, sign * z, sign * r].into_iter().enumerate() {
            self.directions[slab * self.count + point] = value;
        }
    }

    /// Empties the answer.
    pub fn forget(&mut self) {
        self.pressure[..self.count].fill(f64::NAN);
    }

    /// Pressures that the routine gave.
    pub fn pressure(&self) -> &[f64] {
        &self.pressure[..self.count]
    }

    /// Calls the routine; what it answers is still to be accepted.
    ///
    /// # Errors
    /// Its own.
    #[inline(always)]
    pub fn call(&mut self, load: &UserLoad, now: &Instant, amplitude: f64) -> Result<(), LoadFailure> {
        let n = self.count;
        let points = LoadPoints {
            surface: &load.name,
            load_type: load.load_type,
            now: *now,
            amplitude,
            magnitude: load.magnitude.value,
            r: &self.coordinates[..n],
            z: &self.coordinates[n..2 * n],
            velocity_r: &self.motion[..n],
            velocity_z: &self.motion[n..2 * n],
            normal_r: &self.normal_r,
            normal_z: &self.normal_z,
            coordinates: &self.coordinates,
            motion: &self.motion,
            directions: &self.directions,
        };
        let pressure = &mut self.pressure[..n];
        load.routine.with(|r| r.pressure(&points, pressure))
    }

    /// Accepts the answer; `finite` says whether all pressures are, which the caller knows from what it makes of them.
    ///
    /// # Errors
    /// Where one is not, or where the routine wrote past its points.
    #[inline(always)]
    pub fn accept(&mut self, finite: bool) -> Result<(), LoadFailure> {
        if finite && self.pressure[self.count].is_nan() && self.pressure[MAX_BLOCK].is_nan() {
            return Ok(());
        }
        Err(self.refusal())
    }

    #[cold]
    fn refusal(&mut self) -> LoadFailure {
        let n = self.count;
        let point = self.pressure().iter().position(|p| !p.is_finite());
        let Some(i) = point else {
            self.pressure[n..].fill(f64::NAN);
            return LoadFailure::new(format!("it wrote past the nblock = {n} points of its argument value"));
        };
        let value = self.pressure[i];
        let hint = if value.is_nan() {
            "; a point that is left out keeps NaN, and so does what is computed from a third coordinate or direction: \
             curCoords has two, r and z"
        } else {
            ""
        };
        LoadFailure { point, reason: format!("it gave the pressure {value}{hint}") }
    }

    /// A failure in words; `first` points of the load came in blocks before this one.
    pub fn failure(&self, load: &UserLoad, first: usize, now: &Instant, failure: &LoadFailure) -> Halt {
        let place = |i| (self.coordinates[i], self.coordinates[self.count + i]);
        let point = failure.point.filter(|&i| i < self.count).map_or(String::new(), |i| {
            let (r, z) = place(i);
            format!(" at point {} (r = {r}, z = {z})", first + i + 1)
        });
        failure.halt(&format!("the user load on `{}`{point}", load.name), now)
    }
}

impl UserPressure {
    /// The load on points of one body.
    pub fn new(load: UserLoad, body: usize, points: &[Point]) -> Self {
        let blocks = points.chunks(MAX_BLOCK).map(|part| Block::new(part, load.inward)).collect();
        let shows_motion = load.routine.with(|r| r.reads_motion());
        UserPressure { load, body, blocks, shows_motion }
    }
}

impl Block {
    fn new(points: &[Point], inward: bool) -> Block {
        let n = points.len();
        let mut shown = Shown::new(n);
        for (i, point) in points.iter().enumerate() {
            shown.coordinates[i] = point.place[0];
            shown.coordinates[n + i] = point.place[1];
            shown.set_normal(i, point.normal, inward);
        }
        Block {
            elements: points.iter().map(|p| p.element).collect(),
            weight: points.iter().map(|p| p.weight).collect(),
            z_start: points.iter().map(|p| p.place[1]).collect(),
            shown,
            pressure_before: (0..=MAX_BLOCK).map(|i| if i < n { 0.0 } else { f64::NAN }).collect(),
        }
    }

    /// Brings the arrays to this instant and empties the answer, in one pass: for a few facets the passes would cost
    /// more than what they write.
    #[inline]
    fn show(&mut self, body: &BodyState, all: bool) {
        let n = self.z_start.len();
        let Shown { coordinates, motion, pressure, .. } = &mut self.shown;
        let (z, v) = (&mut coordinates[n..2 * n], &mut motion[n..2 * n]);
        // Four at a time: each tile is read before it is written, so nothing need be known of where the arrays lie.
        let tiles = z.as_chunks_mut::<4>().0.iter_mut().zip(v.as_chunks_mut::<4>().0);
        let tiles = tiles.zip(pressure.as_chunks_mut::<4>().0).zip(self.z_start.as_chunks::<4>().0);
        for (((z, v), pressure), start) in tiles {
            *z = start.map(|start| start + body.displacement);
            *v = [body.velocity_load; 4];
            *pressure = [f64::NAN; 4];
        }
        for i in n / 4 * 4..n {
            z[i] = self.z_start[i] + body.displacement;
            v[i] = body.velocity_load;
            pressure[i] = f64::NAN;
        }
        if all {
            motion[3 * n..4 * n].fill(body.displacement);
            motion[5 * n..].fill(body.acceleration);
        }
    }

    fn evaluate(&mut self, load: &UserLoad, now: &Instant, amplitude: f64) -> Result<f64, LoadFailure> {
        self.shown.call(load, now, amplitude)?;
        let force = dot(self.shown.pressure(), &self.weight);
        self.shown.accept(force.is_finite())?;
        Ok(force)
    }

    fn swap_pressures(&mut self) {
        std::mem::swap(&mut self.shown.pressure, &mut self.pressure_before);
    }
}

impl Force for UserPressure {
    fn cause(&self) -> EffectId {
        self.load.cause
    }

    fn slots(&self) -> Vec<Slot> {
        vec![Slot { body: self.body, account: Account::Work }]
    }

    fn evaluate(&mut self, now: &Instant, bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt> {
        let amplitude = self.load.magnitude.amplitude(now);
        let mut force = 0.0;
        let mut failed = None;
        for (i, block) in self.blocks.iter_mut().enumerate() {
            block.swap_pressures();
            block.show(&bodies[self.body], self.shows_motion);
            match block.evaluate(&self.load, now, amplitude) {
                Ok(part) => force += part,
                Err(failure) => {
                    failed = Some((i, failure));
                    break;
                }
            }
        }
        out[0] = force;
        let Some((at, failure)) = failed else { return Ok(()) };
        self.blocks[..=at].iter_mut().for_each(Block::swap_pressures);
        Err(self.blocks[at].shown.failure(&self.load, at * MAX_BLOCK, now, &failure))
    }

    fn limit(&self, now: &Instant, _bodies: &[BodyState]) -> Limit {
        self.load.magnitude.limit(now)
    }

    fn reads_velocity(&self) -> bool {
        true
    }

    fn facet_fields(&self, bodies: &[BodyState]) -> Option<FacetFields> {
        if self.load.load_type == 1 || self.load.load_type == 2 {
            return None;
        }
        let velocity = bodies[self.body].velocity;
        let mut fields = FacetFields::default();
        for block in &self.blocks {
            fields.elements.extend(&block.elements);
            fields.pressure.extend(block.shown.pressure());
            fields.normal_velocity.extend(block.shown.normal_z.iter().map(|n| n * velocity));
            fields.layer.resize(fields.elements.len(), 0.0);
        }
        Some(fields)
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let sum = |f: fn(&Shown) -> &[f64]| self.blocks.iter().map(|b| size_of_val(f(&b.shown))).sum::<usize>();
        vec![
            ("curCoords", sum(|s| &s.coordinates)),
            ("velocity", sum(|s| &s.motion)),
            ("dirCos", sum(|s| &s.directions)),
            ("value", 2 * sum(|s| &s.pressure)),
        ]
    }
}

/// Sum of products in eight interleaved partial sums: the same bits on every instruction set, and no chain of additions.
#[allow(clippy::needless_range_loop)] // Indices that are known keep the sums in registers.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_tiles, a_rest) = a.as_chunks::<8>();
    let (b_tiles, b_rest) = b.as_chunks::<8>();
    for (x, y) in a_tiles.iter().zip(b_tiles) {
        for lane in 0..8 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    let tile = a_rest.first_chunk::<4>().zip(b_rest.first_chunk::<4>());
    if let Some((x, y)) = tile {
        for lane in 0..4 {
            lanes[lane] += x[lane] * y[lane];
        }
        for lane in 4..7 {
            if let (Some(x), Some(y)) = (a_rest.get(lane), b_rest.get(lane)) {
                lanes[lane] += x * y;
            }
        }
    } else {
        for lane in 0..3 {
            if let (Some(x), Some(y)) = (a_rest.get(lane), b_rest.get(lane)) {
                lanes[lane] += x * y;
            }
        }
    }
    ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]))
}

impl Persist for Shown {
    /// Motion, too, of which a routine that does not ask for all has only a part kept up.
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Shown { count: _, coordinates, motion, directions: _, normal_r: _, normal_z: _, pressure } = self;
        persist_fields!(archive; coordinates.as_mut_slice(), motion.as_mut_slice(), pressure.as_mut_slice());
    }
}

impl Persist for Block {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        // The pressures before are those of the instant that is kept, once the next evaluation has begun.
        let Block { elements: _, weight: _, z_start: _, shown, pressure_before: _ } = self;
        shown.persist(archive);
    }
}

impl Persist for UserPressure {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let UserPressure { load: _, body: _, blocks, shows_motion: _ } = self;
        blocks.as_mut_slice().persist(archive);
    }
}
