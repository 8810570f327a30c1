//! New elements in a part of a body, while the others keep their state: where this is possible, and what the nodes keep.

use super::run_state::RunState;
use crate::kernel::lanes::InlineMap;
use crate::plan::RemeshedBody;
use crate::remesh::interpolation::interpolated;
use crate::remesh::{BodyMesh, MeshRevision};

/// Returns whether a part of a body may have new elements while the others keep their state. Mass scaling and thermal strains
/// are transferred by sums over the whole body.
pub(super) fn can_have_patch(run: &RunState<'_>, planned: &RemeshedBody, living: &[usize]) -> bool {
    let RunState { state, .. } = run;
    let has_scaling =
        (0..planned.elements.len()).any(|i| state.elements.mass_scaling.factors_of(planned.group, i).is_some());
    let whole = living.len() == planned.quads.len();
    planned.automatic && whole && !has_scaling && state.thermal.is_none() && state.adaptive.is_empty()
}

/// Returns the places at the start of the nodes of a new mesh.
pub(super) fn starts(
    run: &RunState<'_>,
    planned: &RemeshedBody,
    (old, new): (&BodyMesh, &MeshRevision),
) -> Vec<[f64; 2]> {
    let nodes = &run.state.dofs.nodes;
    let moved: Vec<[f64; 2]> = planned.nodes.iter().map(|n| nodes.displacement(*n)).collect();
    let displacements = interpolated(old, &moved, &new.mesh.points);
    let mut is_unchanged = vec![false; new.mesh.points.len()];
    new.mesh.quads[..new.unchanged].iter().flatten().for_each(|n| is_unchanged[*n as usize] = true);
    let start = |i: usize| match is_unchanged[i] {
        true => nodes.start[planned.nodes[new.parents[i][0] as usize]],
        false => [0, 1].inline_map(|k: usize| new.mesh.points[i][k] - displacements[i][k]),
    };
    (0..is_unchanged.len()).map(start).collect()
}

#[cfg(test)]
mod tests {
    use super::super::observe::RunOutput;
    use super::super::remesh::{NextMesh, next_mesh};
    use super::super::run::SolverRun;
    use super::super::{RunControl, Sink, SinkError, run_with};
    use crate::element::group::ElementGroup;
    use crate::plan::{self, CompiledModel};
    use crate::state::Instant;
    use crate::state::dofs::Dofs;
    use crate::user::Routines;
    use crate::variables::{Variable, VariableComponent};
    use crate::{deck, model};

    /// Increments before the first new mesh. Elements at the foot are flat, but they have not cost enough yet.
    const INCREMENTS: u64 = 140;

    struct NoOutput;
    impl Sink for NoOutput {
        fn row(&mut self, _: &Instant, _: &[f64]) -> Result<(), SinkError> {
            Ok(())
        }
    }

    /// Returns the bits of all variables of an element, and of its corner masses.
    fn variables(group: &dyn ElementGroup, element: usize) -> Vec<u64> {
        let components = |variable: Variable| (0..6).map(move |component| VariableComponent { variable, component });
        let values = Variable::ALL.iter().copied().flat_map(components).filter_map(|part| group.value(element, part));
        values.chain(group.masses(element).iter().copied()).map(f64::to_bits).collect()
    }

    /// Returns the bits of the place, the displacement, the velocity and the mass of a node.
    fn motion(dofs: &Dofs, n: usize) -> [u64; 7] {
        let nodes = &dofs.nodes;
        let ([r, z], [u_r, u_z], [v_r, v_z]) = (nodes[n].place(), nodes.displacement(n), nodes.velocity_now(n));
        [r, z, u_r, u_z, v_r, v_z, nodes.mass[n]].map(f64::to_bits)
    }

    /// Returns the mass, the momentum along r and z, and the kinetic energy of the velocities at this instant.
    fn sums(dofs: &Dofs) -> [f64; 4] {
        let of_node = |n: usize| {
            let (mass, [r, z]) = (dofs.nodes.mass[n], dofs.nodes.velocity_now(n));
            [mass, mass * r, mass * z, 0.5 * mass * (r * r + z * z)]
        };
        (0..dofs.nodes.len()).map(of_node).fold([0.0; 4], |sum, of_node| [0, 1, 2, 3].map(|i| sum[i] + of_node[i]))
    }

    /// A fast copper bar with a constant modulus, and with an equation of state: elements at its foot are replaced. Source: the
    /// state just before. All other elements and their nodes keep their numbers and every bit of their state, except nodes
    /// in common with new elements. Mass and momentum are the same to rounding, and the energy balance has the lost kinetic energy.
    #[test]
    fn elements_outside_a_patch_keep_every_bit() {
        let text = std::fs::read_to_string("../../input/taylor_copper.inp").expect("the deck");
        let settings = [("radius", "3e-3"), ("length", "30e-3"), ("speed", "450."), ("nr", "6"), ("nz", "60")];
        let settings = settings.map(|(name, value)| (name.to_owned(), value.to_owned()));
        let constant = "*Elastic\n 117.e9, 0.35\n";
        let of_state = "*Elastic, type=SHEAR\n 47.7e9,\n*Eos, type=USUP\n 3940., 1.489, 2.02\n";
        for law in [constant, of_state] {
            let (deck, _) = deck::read_text("bar.inp", &text.replacen(constant, law, 1), &settings);
            let CompiledModel { plan, state, .. } = plan::compile(&model::build(&deck).0, &Routines::none());
            let control = RunControl { most_increments: Some(INCREMENTS), ..RunControl::default() };
            let (outcome, state) = run_with(&plan, state, &mut NoOutput, control).expect("a run");
            assert!(outcome.new_meshes.is_empty() && outcome.increments == INCREMENTS);

            let mut run = SolverRun::new(&plan, state.clone(), None);
            run.current.use_step(&plan.steps[0]);
            let total_time = outcome.steps[0].time;
            run.current.now =
                Instant { step: 1, increment: INCREMENTS, step_time: total_time, total_time, ..Instant::default() };
            run.current.complete = true;
            let next = next_mesh(&mut run, 0, &mut RunOutput::new(&plan)).expect("a plan").expect("a mesh");
            let NextMesh { plan: new_plan, run: next } = next;
            let (old, new, monitor) = (&state, next.state(), next.monitor());
            let revision = &monitor.revisions[0];
            let count = revision.mesh.quads.len() - revision.unchanged;
            println!("{count} new elements, {} unchanged", revision.unchanged);
            assert!(count > 20 && 2 * revision.unchanged > plan.mesh.elements.len());

            let waiting = plan.automatic_meshes.as_ref().expect("a body").remesh_plan(&plan.places);
            let [before, after] = [&waiting.bodies[0], &new_plan.remesh.as_ref().expect("a body").bodies[0]];
            for (i, origin) in revision.origins[..revision.unchanged].iter().enumerate() {
                let [from, to] = [before.elements[*origin as usize], after.elements[i]].map(|e| e as usize);
                assert_eq!(plan.element_name(0, from), new_plan.element_name(0, to));
                let [from, to] = [(old, from), (new, to)].map(|(state, e)| variables(&*state.elements.groups[0], e));
                assert_eq!(from, to, "element {i}");
            }
            let (unchanged, renewed) = revision.mesh.quads.split_at(revision.unchanged);
            let mut is_renewed = vec![false; revision.mesh.points.len()];
            renewed.iter().flatten().for_each(|n| is_renewed[*n as usize] = true);
            for i in unchanged.iter().flatten().map(|n| *n as usize) {
                let [from, to] = [before.nodes[revision.parents[i][0] as usize], after.nodes[i]];
                let bits = [motion(&old.dofs, from), motion(&new.dofs, to)].map(|bits| bits.to_vec());
                let kept = if is_renewed[i] { 0..4 } else { 0..7 };
                assert_eq!(bits[0][kept.clone()], bits[1][kept], "node {i}");
            }

            let [[mass, r, z, energy], [new_mass, new_r, new_z, _]] = [&old.dofs, &new.dofs].map(sums);
            let size = (mass * energy).sqrt();
            let apart = [new_mass / mass - 1.0, (new_r - r) / size, (new_z - z) / size];
            println!("mass {:.1e}, momentum {:.1e} and {:.1e}", apart[0], apart[1], apart[2]);
            assert!(apart.iter().all(|x| x.abs() < 1e-12), "{apart:?}");
            let lost = new.dofs.energies.advection;
            let kinetic = [old, new].map(|state| state.dofs.energies.kinetic);
            assert!((kinetic[0] - kinetic[1] - lost).abs() < 1e-12 * energy, "{lost} {kinetic:?}");
            assert!(lost != 0.0 && monitor.bodies[0].lost_energy == lost, "{lost}");
        }
    }
}
