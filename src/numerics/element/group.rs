//! Interface of element groups.

use pulp::Arch;

use super::cohesive::CohesiveGroup;
use super::constants::ElementConstants;
use super::criteria::DeletionFilter;
use super::tiles::TilePass;
use crate::kernel::cohesive;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, Pack};
use crate::kernel::quad;
use crate::kernel::shell::ShellFrame;
use crate::kernel::topology::{ElementNodes, ElementTopology, MOST_NODES, PerNode};
use crate::material::PointValue;
use crate::material::available::AvailableEnergy;
use crate::routines::PointRoutines;
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::state::halt::HaltReason;
use crate::state::nodes::{Node, NodeAccelerations};
use crate::variables::{Variable, VariableComponent};

/// Number of elements above which parallel updates are faster.
pub(super) const PARALLEL: usize = 1000;

/// Energy increments and limits of a group from one update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct GroupTotals {
    /// Work of the stress.
    pub internal: f64,
    /// Energy dissipated by plastic flow and damage.
    pub plastic: f64,
    /// Elastic energy lost by damage, a part of `plastic`.
    pub damaged: f64,
    /// Work of the bulk viscosity.
    pub viscous: f64,
    /// Work of the hourglass control.
    pub artificial: f64,
    /// One over the stable time increment.
    pub rate: f64,
    /// Index in the group of the element that limits it.
    pub limiting: usize,
    /// Bound of the relative increase of a frequency by the deformation in this increment: gradients by the largest
    /// strain (norm of the tensor), the root of the volume by half its largest change. 0 unless frequencies are capped.
    pub deformed: f64,
}

/// Properties that all elements of a group share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupProperties {
    /// Shape of the elements.
    pub topology: ElementTopology,
    /// Whether elements can be deleted.
    pub deletable: bool,
    /// Whether bulk viscosity damps the highest modes.
    pub damped: bool,
    /// Whether the pressure follows from density, energy or the total deformation, so that no initial stress can be
    /// prescribed.
    pub holds_pressure: bool,
    /// Whether the pressure follows from density and specific energy.
    pub equation_of_state: bool,
    /// Number of field variables that elements store.
    pub fields: usize,
    /// Whether corner forces may be stored for a part of the elements only.
    pub tiles: bool,
}

/// Elements of one topology and one material.
#[allow(clippy::len_without_is_empty)] // `is_empty` is a method of `dyn ElementGroup`.
pub trait ElementGroup: DeletionFilter + Persist + Send + Sync {
    /// Returns the number of elements.
    fn len(&self) -> usize;
    /// Returns the properties that all elements share.
    fn properties(&self) -> GroupProperties;
    /// Returns the nodes of an element in the order of the topology; for shells also the companion nodes of the
    /// rotations.
    fn nodes(&self, element: usize) -> ElementNodes;
    /// Returns the lumped masses of an element at its nodes; rotary inertias at companion nodes.
    fn masses(&self, element: usize) -> PerNode<f64>;
    /// Sets the masses of an element at its nodes.
    fn set_masses(&mut self, element: usize, masses: &[f64]);
    /// Updates the stresses to the end of an increment, and the corner forces.
    fn update(&mut self, pass: ElementPass<'_>) -> GroupTotals;
    /// Returns the value of a variable that the group stores for an element; `None` if the element does not have it or
    /// a formula computes it.
    fn value(&self, element: usize, part: VariableComponent) -> Option<f64>;
    /// Sets a value of all points of an element. Returns whether the element uses it; other values are ignored.
    fn set(&mut self, element: usize, value: PointValue) -> bool;
    /// Returns the thickness of a shell, or the constitutive thickness of a cohesive element; `None` for solids.
    fn thickness(&self, _element: usize) -> Option<f64> {
        None
    }
    /// Returns one over the stable time increment of an element at the current positions, by the bound of the inner
    /// loop with linear bulk viscosity only and without a bound of the whole model. Uses `masses` instead of the
    /// element's own masses if given; `None` if the masses cannot be scaled.
    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64>;
    /// Returns the elastic stiffness of an element at the current positions; `None` for an element that is not linear
    /// elastic at small strain, which has no highest frequency in this sense.
    fn stiffness(&self, _element: usize, _nodes: &[Node]) -> Option<ElementStiffness> {
        None
    }
    /// Returns whether a task of elements is skipped because all its elements are at rest and free of stress.
    fn is_quiescent(&self, _task: usize) -> bool {
        false
    }
    /// Returns the energy that an element can release from its initial state.
    fn available_energy(&self, _element: usize, _nodes: &[Node]) -> AvailableEnergy {
        AvailableEnergy::NONE
    }
    /// Applies a setting to all elements; a setting that the elements do not use is ignored.
    fn configure(&mut self, setting: GroupSetting);
    /// Deletes an element after [`GroupSetting::Deletion`]; `volume` is its initial volume if it is solid.
    /// [`ElementGroup::newly_deleted`] does not list it.
    fn erode(&mut self, element: usize, volume: f64);
    /// Appends the boundaries of elements that the last update deleted.
    fn newly_deleted(&mut self, _deleted: &mut Vec<ElementNodes>) {}
    /// Returns the functions of solid elements; `None` for other elements.
    fn as_solid(&mut self) -> Option<&mut dyn SolidElements> {
        None
    }
    /// Returns the group if its elements are cohesive.
    fn as_cohesive(&mut self) -> Option<&mut CohesiveGroup> {
        None
    }
    /// Returns the bytes of the arrays of the group.
    fn bytes(&self) -> usize;
    /// Returns a copy of the group in the same state.
    fn copy(&self) -> Box<dyn ElementGroup>;
}

/// Setting of a group.
#[derive(Clone, Copy, Debug)]
pub enum GroupSetting {
    /// Strains and energies are recorded for output.
    Records,
    /// The stable time increments of elements are stored; mass scaling finds the current stiffness of rubber from them.
    StableRates,
    /// The memory for factors of mass scaling is allocated, where the density of a law is that without scaling.
    MassScales,
    /// The memory that [`ElementGroup::erode`] needs is allocated.
    Deletion,
    /// Bound of the highest frequency of the whole model, radians per time; infinite if unknown.
    HighestFrequency(f64),
    /// Instruction set of the updates; results have the same bits.
    Instructions(Arch),
}

/// Damage above which an element that stays has failed.
const FAILED: f64 = 0.5;

impl dyn ElementGroup + '_ {
    /// Returns whether the group has no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the shape of the elements.
    pub fn topology(&self) -> ElementTopology {
        self.properties().topology
    }

    /// Returns whether the boundary of an element encloses its volume.
    pub fn is_solid(&self) -> bool {
        self.topology().is_solid()
    }

    /// Returns whether an element has failed but stays (`*FAILED MATERIAL`, `ELEMENT DELETION=NO`).
    pub fn has_failed(&self, element: usize) -> bool {
        let damage = || self.value(element, Variable::Degradation.into());
        !self.properties().deletable && damage().is_some_and(|damage| damage > FAILED)
    }

    /// Returns the number of blocks of corner forces of all elements.
    pub fn force_blocks(&self) -> usize {
        self.len().div_ceil(LANES) * self.topology().force_blocks()
    }

    /// Returns the nodes on the boundary of an element, without rotations.
    pub fn boundary(&self, element: usize) -> ElementNodes {
        self.nodes(element).first(self.topology().boundary())
    }

    /// Returns the corner nodes of the quadrilateral cells of a solid element.
    pub fn cells(&self, element: usize) -> impl Iterator<Item = [u32; 4]> {
        let nodes = self.nodes(element);
        self.topology().cells().iter().map(move |cell| cell.inline_map(|i| nodes[i]))
    }

    /// Returns [`SolidElements::transfer`]; `None` also for other elements.
    pub fn transfer(&mut self) -> Option<&mut dyn ElementTransfer> {
        self.as_solid()?.transfer()
    }

    /// Returns [`SolidElements::user`]; `None` also for other elements.
    pub fn user(&mut self) -> Option<&mut dyn UserCalls> {
        self.as_solid()?.user()
    }

    /// Returns whether an element of the group is deleted.
    pub fn is_deleted(&self, element: usize) -> bool {
        self.value(element, Variable::Status.into()) == Some(0.0)
    }

    /// Returns the volume of an element at the current positions.
    pub fn volume(&self, element: usize, nodes: &[Node]) -> f64 {
        self.volume_at(element, |n| nodes[n as usize].place())
    }

    /// Returns the volume of an element for given node positions.
    pub fn volume_at(&self, element: usize, place: impl Fn(u32) -> [f64; 2]) -> f64 {
        if self.is_solid() {
            return self.cells(element).map(|cell| quad::volume(cell.inline_map(&place))).sum();
        }
        let (nodes, thickness) = (self.nodes(element), self.thickness(element).unwrap_or(0.0));
        if self.topology() == ElementTopology::Cohesive {
            let [a, b] = cohesive::areas([0, 1, 2, 3].inline_map(|i: usize| place(nodes[i])));
            return thickness * (a + b);
        }
        ShellFrame::new([0, 1].inline_map(|i| place(nodes[i]))).area() * thickness
    }
}

/// Work of a thermal strain.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExpansionWork {
    /// Stress work that the element update omits.
    pub omitted: f64,
    /// Energy that the temperature puts in: the work of the stress on the thermal strain, with opposite sign.
    pub supplied: f64,
}

/// Elastic stiffness of an element, rows and columns `[r, z]` of each node in turn.
#[derive(Clone, Copy, Debug)]
pub struct ElementStiffness(pub [[f64; 2 * MOST_NODES]; 2 * MOST_NODES]);

impl ElementStiffness {
    /// Stiffness of a deleted element.
    pub const ZERO: ElementStiffness = ElementStiffness([[0.0; 2 * MOST_NODES]; 2 * MOST_NODES]);
}

impl<const N: usize> From<[[f64; N]; N]> for ElementStiffness {
    fn from(list: [[f64; N]; N]) -> Self {
        let ElementStiffness(mut matrix) = ElementStiffness::ZERO;
        matrix.iter_mut().zip(list).for_each(|(row, entries)| row[..N].copy_from_slice(&entries));
        ElementStiffness(matrix)
    }
}

/// Functions of solid elements.
pub trait SolidElements {
    /// Writes the temperatures of the elements, including the rise by plastic work, to `out`; entries of elements
    /// without temperature are unchanged.
    fn temperatures(&self, out: &mut [f64]);
    /// Sets a variable of all elements to the means of their nodes at the end of an increment.
    fn set_means(&mut self, variable: NodalVariable, means: &[f64]);
    /// Subtracts increments of the thermal strain from the strains of the next update, which covers the increment `dt`
    /// that ends at these nodes.
    fn expand(&mut self, strains: &[f64], nodes: &[Node], dt: f64) -> ExpansionWork;
    /// Returns the interface for user subroutines; `None` for materials without calls.
    fn user(&mut self) -> Option<&mut dyn UserCalls>;
    /// Returns the interface to the variables that move through an adaptive mesh; `None` if some cannot move.
    fn transfer(&mut self) -> Option<&mut dyn ElementTransfer>;
}

/// Variable of nodes that elements use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodalVariable {
    Temperature,
    /// Field variable, by its index below [`GroupProperties::fields`].
    Field(usize),
}

/// Interface to the variables of a group that move with the material.
pub trait ElementTransfer {
    /// Returns the number of variables of an element.
    fn variables(&mut self) -> usize;
    /// Allocates what [`ElementTransfer::write`] needs, before the first increment.
    fn prepare(&mut self);
    /// Reads the variables of elements in ascending order, per mass, into lists of packs. The second list is whether each
    /// element is read.
    fn read(&mut self, elements: (&[u32], &[bool]), packs: &mut [Vec<Pack>]);
    /// Writes the variables, and the masses of the elements at their corners. The second list is whether each element is
    /// written.
    fn write(&mut self, elements: (&[u32], &[bool]), packs: &[Vec<Pack>], arrived: ArrivedElements<'_>);
    /// Returns [`crate::material::Material::volume_ratio`] of an element.
    fn volume_ratio(&self, element: u32) -> Option<f64>;
    /// Passes all variables and masses of each element to `visit`, which may change them.
    fn visit_elements(&mut self, elements: &[u32], visit: &mut dyn FnMut(&mut f64));
}

/// Elements of a domain after a transport, in its order.
#[derive(Clone, Copy)]
pub struct ArrivedElements<'a> {
    /// Masses at the corners.
    pub masses: &'a [[f64; 4]],
    /// Nodes of the corners, as indices of `places`.
    pub corners: &'a [[u32; 4]],
    /// Places of the nodes.
    pub places: &'a [[f64; 2]],
}

/// User subroutines that a group calls.
pub trait UserCalls {
    /// Calls the user material at the start of the analysis to determine its moduli, before mass scaling and the
    /// estimate of the highest frequency.
    ///
    /// # Errors
    /// The failure of the subroutine, or an inelastic response.
    fn probe(&mut self, nodes: &[Node], now: &Instant, user: PointRoutines<'_>) -> Result<(), HaltReason>;
    /// Returns the failure of the subroutine in the last update.
    fn failure(&self) -> Option<HaltReason>;
    /// Returns the constants of the elements; bulk and shear modulus are the largest of all elements.
    fn constants(&mut self) -> &mut ElementConstants;
}

/// Input of the update of a group.
pub struct ElementPass<'a> {
    /// All nodes, at current positions.
    pub nodes: &'a [Node],
    /// Length of the previous increment.
    pub dt: f64,
    /// Accelerations that moved the nodes over it.
    pub before: NodeAccelerations<'a>,
    /// Instant at which the nodes have their current positions.
    pub now: &'a Instant,
    /// Whether the update may use several threads.
    pub threads: bool,
    /// User subroutines that are called at points.
    pub user: PointRoutines<'a>,
    /// Destination of the corner forces of the group that are stored.
    pub corners: &'a mut [BlockCornerForces],
    /// Tiles in which corner forces are summed; `None` if all are stored.
    pub tiles: Option<TilePass<'a>>,
    /// Averaged minus own volumetric strain increment of each element, block by block; `None` without averaging.
    pub dilation_correction: Option<&'a [Lanes]>,
    /// Whether data of later blocks are requested in advance; groups may ignore it.
    pub prefetches: bool,
}

impl Clone for Box<dyn ElementGroup> {
    fn clone(&self) -> Self {
        self.copy()
    }
}
