//! Report on bodies in targets without mesh at the end of a run.

use super::outcome::{BodyExit, ImpactEnd, Outcome, PenetrationSummary};
use super::run_state::RunState;
use crate::load::{FinalMotion, Load, PenetrationOutcome, PenetrationRecord};
use crate::plan::State;

/// Stores the outcomes of bodies in resistances that end with a step.
pub(super) fn record_ended_penetrations(state: &mut State, ended: &[Box<dyn Load>]) {
    let records = ended.iter().flat_map(|load| load.penetrations(&state.dofs));
    let is_final = |p: &PenetrationRecord| p.in_space.is_some() || p.outcome == PenetrationOutcome::Through;
    state.ended_penetrations.extend(records.filter(is_final));
}

impl Outcome {
    /// Reports the outcomes of bodies in targets at the end of the run.
    pub(super) fn report_penetrations(&mut self, run: &RunState<'_>) {
        let in_force = run.state.loads.iter().flat_map(|load| load.penetrations(&run.state.dofs)).collect();
        let records = latest_penetrations(&run.state.ended_penetrations, in_force);
        let has_met = !records.is_empty() && records.iter().all(|p| p.outcome != PenetrationOutcome::NotMet);
        if has_met && run.energy().cavity == 0.0 && self.halt.is_none() {
            let text = "no resistance of a target has acted, although a body has passed through it: the loaded faces point \
                        backwards, or the target has no strength. Check the side of the surface (SPOS or SNEG)";
            self.warn("R326", text);
        }
        for PenetrationRecord { body, outcome, in_space } in records {
            let speed = in_space.map_or(run.state.dofs.bodies[body].velocity.abs(), |motion| motion.speed);
            self.impacts.push(ImpactEnd { body, outcome, speed });
            let name = run.plan.bodies[body].name.clone();
            match in_space {
                None => self.report_along_z(name, outcome, run.state.dofs.bodies[body].velocity),
                Some(motion) => self.report_in_space(name, outcome, motion),
            }
        }
    }

    fn warn_of_missed_target(&mut self, body: &str) {
        let text = format!("{body} has not reached its target until the end of the run: no resistance has acted");
        self.warn("R326", text);
    }

    fn report_along_z(&mut self, body: String, outcome: PenetrationOutcome, velocity: f64) {
        match outcome {
            PenetrationOutcome::Moving => {
                self.still_moving += 1;
                self.unfinished.push(format!(
                    "{body} still moves in the target, v_z = {velocity:.4e}: its penetration depth is not final"
                ));
            }
            PenetrationOutcome::Through => {
                self.unfinished.push(format!(
                    "{body} has left the target through its back, v_z = {velocity:.4e}: it has no penetration depth"
                ));
                self.exits.push(BodyExit { body, velocity });
            }
            PenetrationOutcome::NotMet => self.warn_of_missed_target(&body),
            PenetrationOutcome::AtRest | PenetrationOutcome::Ricochet => {}
        }
    }

    fn report_in_space(&mut self, body: String, outcome: PenetrationOutcome, motion: FinalMotion) {
        let speed = motion.speed;
        let exit = format!(
            "at time {:.4e}; residual speed {speed:.4e}, obliquity {:.2} deg, yaw {:.2} deg",
            motion.exit_time.unwrap_or_default(),
            motion.obliquity,
            motion.yaw
        );
        match outcome {
            PenetrationOutcome::Moving => {
                self.still_moving += 1;
                self.unfinished.push(format!(
                    "{body} still moves in the target, speed {speed:.4e}: its penetration depth is not final"
                ));
            }
            PenetrationOutcome::Through => {
                self.unfinished.push(format!("{body} has left the target through its back {exit}"));
            }
            PenetrationOutcome::Ricochet => {
                self.unfinished.push(format!("{body} has ricocheted: it left the target through its front {exit}"))
            }
            PenetrationOutcome::NotMet => self.warn_of_missed_target(&body),
            PenetrationOutcome::AtRest => {}
        }
        self.penetrations.push(PenetrationSummary {
            body,
            end: outcome.words(),
            exit_time: motion.exit_time,
            velocity: motion.velocity,
            rotational_velocity: motion.rotational_velocity,
            speed,
            obliquity: motion.obliquity,
            yaw: motion.yaw,
            tilt: motion.tilt,
        });
    }
}

/// Returns the outcome of each body: from resistances that have ended, unless the body has met one in force since.
pub(super) fn latest_penetrations(
    ended: &[PenetrationRecord],
    in_force: Vec<PenetrationRecord>,
) -> Vec<PenetrationRecord> {
    let is_met = |p: &&PenetrationRecord| p.outcome != PenetrationOutcome::NotMet;
    let is_newer = |p: &PenetrationRecord| in_force.iter().filter(is_met).any(|other| other.body == p.body);
    let mut records: Vec<PenetrationRecord> = ended.iter().filter(is_met).filter(|p| !is_newer(p)).copied().collect();
    let ended_bodies: Vec<usize> = records.iter().map(|record| record.body).collect();
    records.extend(in_force.iter().filter(|p| !ended_bodies.contains(&p.body)));
    records
}
