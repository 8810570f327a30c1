//! Report on bodies in targets without mesh at the end of a run.

use super::outcome::{BodyExit, ImpactEnd, PenetrationSummary};
use super::run::SolverRun;
use crate::load::{Load, PenetrationOutcome, PenetrationRecord};

impl SolverRun<'_> {
    /// Stores the outcomes of bodies in resistances that end with a step.
    pub(super) fn record_ended_penetrations(&mut self, ended: &[Box<dyn Load>]) {
        let all = ended.iter().flat_map(|load| load.penetrations(&self.state.dofs));
        let is_final = |p: &PenetrationRecord| p.in_space.is_some() || p.outcome == PenetrationOutcome::Through;
        self.state.ended_penetrations.extend(all.filter(is_final));
    }

    /// Reports the outcomes of bodies in targets at the end of the run.
    pub(super) fn report_penetrations(&mut self) {
        let in_force = self.state.loads.iter().flat_map(|load| load.penetrations(&self.state.dofs)).collect();
        for penetration in latest_penetrations(&self.state.ended_penetrations, in_force) {
            let PenetrationRecord { body, outcome, in_space } = penetration;
            let speed = in_space.map_or(self.state.dofs.bodies[body].velocity.abs(), |motion| motion.speed);
            self.outcome.impacts.push(ImpactEnd { body, outcome, speed });
            let name = self.plan.bodies[penetration.body].name.clone();
            match penetration.in_space {
                None => self.report_along_z(name, &penetration),
                Some(_) => self.report_in_space(name, &penetration),
            }
        }
    }

    fn report_along_z(&mut self, body: String, penetration: &PenetrationRecord) {
        let velocity = self.state.dofs.bodies[penetration.body].velocity;
        match penetration.outcome {
            PenetrationOutcome::Moving => {
                self.outcome.still_moving += 1;
                self.outcome.unfinished.push(format!(
                    "{body} still moves in the target, v_z = {velocity:.4e}: its penetration depth is not final"
                ));
            }
            PenetrationOutcome::Through => {
                self.outcome.unfinished.push(format!(
                    "{body} has left the target through its back, v_z = {velocity:.4e}: it has no penetration depth"
                ));
                self.outcome.exits.push(BodyExit { body, velocity });
            }
            PenetrationOutcome::AtRest | PenetrationOutcome::Ricochet | PenetrationOutcome::NotMet => {}
        }
    }

    fn report_in_space(&mut self, body: String, penetration: &PenetrationRecord) {
        let Some(motion) = &penetration.in_space else { return };
        let speed = motion.speed;
        let exit = format!(
            "at time {:.4e}; residual speed {speed:.4e}, obliquity {:.2} deg, yaw {:.2} deg",
            motion.exit_time.unwrap_or_default(),
            motion.obliquity,
            motion.yaw
        );
        match penetration.outcome {
            PenetrationOutcome::Moving => {
                self.outcome.still_moving += 1;
                self.outcome.unfinished.push(format!(
                    "{body} still moves in the target, speed {speed:.4e}: its penetration depth is not final"
                ));
            }
            PenetrationOutcome::Through => {
                self.outcome.unfinished.push(format!("{body} has left the target through its back {exit}"));
            }
            PenetrationOutcome::Ricochet => self
                .outcome
                .unfinished
                .push(format!("{body} has ricocheted: it left the target through its front {exit}")),
            PenetrationOutcome::AtRest | PenetrationOutcome::NotMet => {}
        }
        self.outcome.penetrations.push(PenetrationSummary {
            body,
            end: penetration.outcome.words(),
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
    let kept: Vec<PenetrationRecord> = ended.iter().filter(is_met).filter(|p| !is_newer(p)).copied().collect();
    let rest = in_force.iter().filter(|p| kept.iter().all(|other| other.body != p.body));
    kept.iter().chain(rest).copied().collect()
}
