//! Mass scaling (`*FIXED MASS SCALING`, `*VARIABLE MASS SCALING`): which factor each element's mass carries, when it is
//! found anew, and what follows it: masses of nodes, of elements, forces by mass, the work that added mass costs.
//! Never here: the inner loop, deck words.

use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::PerNode;
use crate::state::archive::persist_struct;

/// How a stable increment that is aimed at decides on factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// Elements whose own stable increment is below it are brought up to it.
    BelowMin,
    /// One factor for all of the set: that of its smallest own stable increment.
    Uniform,
    /// Every element is brought to it, up or down.
    SetEqual,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Group and element of those that it scales.
    pub elements: Vec<(usize, usize)>,
    /// Factor on the mass; comes before the increment that is aimed at.
    pub factor: f64,
    /// Stable increment aimed at, time, and how.
    pub aim: Option<(Aim, f64)>,
}

/// When variable requests are evaluated anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rhythm {
    /// Every so many increments of the step.
    Increments(u64),
    /// Whenever so much time of the step has gone by.
    Time(f64),
}

/// A variable request with its rhythm, and when it is due next: increments or intervals of the step.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// What is scaled and how.
    pub request: Request,
    pub rhythm: Rhythm,
    due: u64,
}

impl Variable {
    /// Due at the start of the step for the first time.
    pub fn new(request: Request, rhythm: Rhythm) -> Self {
        Variable { request, rhythm, due: 0 }
    }

    /// Whether it is due at this instant; if so it waits for the next turn.
    pub(super) fn take_turn(&mut self, increment: u64, step_time: f64) -> bool {
        let (reached, next) = match self.rhythm {
            Rhythm::Increments(every) => (increment >= self.due, increment + every),
            Rhythm::Time(every) => (step_time >= self.due as f64 * every, (step_time / every) as u64 + 1),
        };
        if reached {
            self.due = next;
        }
        reached
    }
}

/// Mass scaling of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scaling {
    /// Those evaluated once, at the start of the step; `None` where those of an earlier step go on.
    pub fixed: Option<Vec<Request>>,
    pub variable: Vec<Variable>,
    /// Increment in which the step began.
    pub(super) first: Option<u64>,
}

impl Scaling {
    /// For a step that has not begun.
    pub fn new(fixed: Option<Vec<Request>>, variable: Vec<Variable>) -> Self {
        Scaling { fixed, variable, first: None }
    }
}

/// Masses without scaling and the factors on them. Room for all, so that nothing allocates inside an increment.
#[derive(Clone, Debug)]
pub struct Masses {
    pub(super) nodes: Vec<f64>,
    /// Of elements at their nodes, by group.
    pub(super) elements: Vec<Vec<PerNode<f64>>>,
    /// Nodes whose mass stays: those that rigid bodies carry or equations keep; empty without any.
    pub(super) left: Vec<bool>,
    /// Factors of fixed requests, and all together.
    pub(super) fixed: Vec<Vec<f64>>,
    pub(super) factors: Vec<Vec<f64>>,
    /// Factors that the elements have now.
    pub(super) carried: Vec<Vec<f64>>,
    /// Masses of nodes with the factors.
    pub(super) sums: Vec<f64>,
}

impl Scaling {
    /// A step begins in which it goes on: what is due by the time of the step has just been done.
    pub fn begin_step(&mut self) {
        let by_time = self.variable.iter_mut().filter(|v| matches!(v.rhythm, Rhythm::Time(_)));
        by_time.for_each(|variable| variable.due = 1);
    }

    pub fn bytes(&self) -> usize {
        let of = |r: &Request| size_of_val(r) + heap_bytes(&r.elements);
        self.fixed.iter().flatten().map(of).sum::<usize>() + self.variable.iter().map(|v| of(&v.request)).sum::<usize>()
    }
}

persist_struct!(Variable { due } derived { request, rhythm });

persist_struct!(Scaling { variable: fixed, first } derived { fixed });

impl Masses {
    /// Whether a node keeps its mass.
    pub(super) fn stays(&self, node: u32) -> bool {
        self.left.get(node as usize).copied().unwrap_or(false)
    }

    /// Masses of an element at its nodes under a factor.
    pub(super) fn scaled(&self, group: usize, element: usize, nodes: &[u32], factor: f64) -> PerNode<f64> {
        let mut masses = self.elements[group][element];
        let scaled = masses.iter_mut().zip(nodes).filter(|(_, node)| !self.stays(**node));
        scaled.for_each(|(mass, _)| *mass *= factor);
        masses
    }

    pub fn bytes(&self) -> usize {
        let of = |lists: &Vec<Vec<f64>>| lists.iter().map(|l| 8 * l.capacity()).sum::<usize>();
        let elements: usize = self.elements.iter().map(heap_bytes).sum();
        of(&self.fixed)
            + of(&self.factors)
            + of(&self.carried)
            + elements
            + self.left.capacity()
            + 8 * (self.nodes.capacity() + self.sums.capacity())
    }
}

// Of nodes and elements, masses without factors and what stays are those of the plan; the scaled ones are computed anew.
persist_struct!(Masses {
    fixed: fixed_lists, factors: fixed_lists, carried: fixed_lists
} derived {
    nodes, elements, left, sums
});
