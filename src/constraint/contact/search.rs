//! Which facets may meet within the next increments: lists that hold until something has moved too far.
//! Never here: gaps.

use crate::kernel::lists::MemoryUse;

use super::curve::Curve;

/// Part of the pair's length of facets that is the reach of contact: points further from the other surface are out of it.
const REACH: f64 = 0.5;
/// Part of it that a point may move before lists are made anew. Both surfaces may move so far: boxes are widened by reach and
/// twice this.
const SLACK: f64 = 0.5;

/// A box, by its lower and upper corner.
type Bounds = [[f64; 2]; 2];

/// For each facet of one curve the facets of another that it may meet, ascending, and the same for points that no element has.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// The length that reach and slack are parts of: the smaller of the longest facets of both.
    pub length: f64,
    /// How far in front of their facets both surfaces lie at most.
    pub lift: f64,
    /// By place among the bare facets of the own curve.
    pub facets: Lists,
    /// By place among the own curve's orphans, in front of the other curve.
    pub orphans: Lists,
    /// By place among the other curve's loose points, in front of the own one.
    pub others: Lists,
    order: Order,
}

#[derive(Clone, Debug, Default)]
pub struct Lists {
    first: Vec<u32>,
    list: Vec<u32>,
}

impl Lists {
    #[inline]
    pub fn of(&self, index: usize) -> &[u32] {
        match (self.first.get(index), self.first.get(index + 1)) {
            (Some(&from), Some(&to)) => &self.list[from as usize..to as usize],
            _ => &[],
        }
    }

    fn clear(&mut self) {
        self.first.clear();
        self.list.clear();
        self.first.push(0);
    }

    fn end_one(&mut self) {
        let from = self.first[self.first.len() - 1] as usize;
        self.list[from..].sort_unstable();
        self.first.push(self.list.len() as u32);
    }

    fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.first) + MemoryUse::of(&self.list)
    }
}

/// Bare facets of a curve by where their boxes begin along the direction in which it is longer.
#[derive(Clone, Debug, Default)]
struct Order {
    axis: usize,
    longest: f64,
    order: Vec<(f64, u32)>,
}

impl Order {
    fn sort(&mut self, curve: &Curve) {
        self.axis = longer_extent(curve);
        self.longest = 0.0;
        self.order.clear();
        for &j in &curve.bare {
            let [low, high] = curve.shapes[j as usize].bounds();
            self.order.push((low[self.axis], j));
            self.longest = self.longest.max(high[self.axis] - low[self.axis]);
        }
        self.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Adds the facets whose boxes come within `margin` of one.
    fn near(&self, curve: &Curve, [low, high]: Bounds, margin: f64, mut add: impl FnMut(u32)) {
        let axis = self.axis;
        let from = self.order.partition_point(|o| o.0 < low[axis] - margin - self.longest);
        for &(_, j) in self.order[from..].iter().take_while(|o| o.0 <= high[axis] + margin) {
            let [l, h] = curve.shapes[j as usize].bounds();
            if (0..2).all(|i| l[i] <= high[i] + margin && h[i] >= low[i] - margin) {
                add(j);
            }
        }
    }
}

impl Search {
    /// Room for lists of curves of so many facets.
    pub fn new(length: f64, lift: f64, facets: usize, others: usize) -> Search {
        let room =
            |count: usize, list: usize| Lists { first: Vec::with_capacity(count), list: Vec::with_capacity(list) };
        Search {
            length,
            lift,
            facets: room(facets + 1, 16 * (facets + others)),
            orphans: room(facets + 1, 4 * facets),
            others: room(others + 1, 4 * others),
            order: Order { order: Vec::with_capacity(facets.max(others)), ..Order::default() },
        }
    }

    /// How far points may move before lists are made anew.
    pub fn slack(&self) -> f64 {
        SLACK * self.length
    }

    /// How far in front of a surface contact begins to be looked at.
    pub fn reach(&self) -> f64 {
        REACH * self.length
    }

    /// Makes the lists. A curve that meets itself (`other` is `None`) has each two facets once, under the lower index. Facets
    /// with a point in common do not meet.
    pub fn build(&mut self, own: &Curve, other: Option<&Curve>, places: &[[f64; 2]]) {
        let (against, margin) = (other.unwrap_or(own), self.reach() + self.lift + 2.0 * self.slack());
        let Search { facets, orphans, others, order, .. } = self;
        order.sort(against);
        facets.clear();
        for &k in &own.bare {
            let shape = &own.shapes[k as usize];
            order.near(against, shape.bounds(), margin, |j| {
                let seen_already = other.is_none() && j <= k;
                let neighbours = own.facets[k as usize].iter().any(|p| against.facets[j as usize].contains(p));
                if !seen_already && !neighbours {
                    facets.list.push(j);
                }
            });
            facets.end_one();
        }
        list_points(orphans, (own, own.orphans.iter().copied()), against, order, places, margin);
        if let Some(other) = other.filter(|o| o.loose().next().is_some()) {
            order.sort(own);
            list_points(others, (other, other.loose()), own, order, places, margin);
        }
    }

    /// Memory of the lists.
    pub fn memory(&self) -> MemoryUse {
        [&self.facets, &self.orphans, &self.others].into_iter().map(Lists::memory).sum::<MemoryUse>()
            + MemoryUse::of(&self.order.order)
    }
}

fn list_points(
    lists: &mut Lists,
    (of, points): (&Curve, impl Iterator<Item = u32>),
    against: &Curve,
    order: &Order,
    places: &[[f64; 2]],
    margin: f64,
) {
    lists.clear();
    for index in points {
        let place = places[of.own[index as usize] as usize];
        order.near(against, [place; 2], margin, |j| lists.list.push(j));
        lists.end_one();
    }
}

/// The direction along which a curve is longer: r (0) or z (1).
fn longer_extent(curve: &Curve) -> usize {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for &k in &curve.bare {
        let [l, h] = curve.shapes[k as usize].bounds();
        for i in [0, 1] {
            (low[i], high[i]) = (low[i].min(l[i]), high[i].max(h[i]));
        }
    }
    usize::from(high[1] - low[1] > high[0] - low[0])
}
