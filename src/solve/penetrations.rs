//! What a run reports at its end of bodies in targets that are not meshed.
//! Never here: resistances.

use super::outcome::{Exit, PenetrationSummary};
use super::run::Run;
use crate::load::{Load, Penetration, PenetrationOutcome};

impl Run<'_> {
    /// Keeps what has become of bodies in resistances that are no longer in force.
    pub(super) fn record_ended_penetrations(&mut self, ended: &[Box<dyn Load>]) {
        let all = ended.iter().flat_map(|load| load.penetrations(&self.state.dofs));
        let is_final = |p: &Penetration| p.in_space.is_some() || p.outcome == PenetrationOutcome::Through;
        self.state.ended_penetrations.extend(all.filter(is_final));
    }

    /// At the end: what has become of bodies in targets.
    pub(super) fn report_penetrations(&mut self) {
        let in_force = self.state.loads.iter().flat_map(|load| load.penetrations(&self.state.dofs)).collect();
        for penetration in latest_penetrations(&self.state.ended_penetrations, in_force) {
            let name = self.plan.bodies[penetration.body].name.clone();
            match penetration.in_space {
                None => self.report_along_z(name, &penetration),
                Some(_) => self.report_in_space(name, &penetration),
            }
        }
    }

    fn report_along_z(&mut self, body: String, penetration: &Penetration) {
        let velocity = self.state.dofs.bodies[penetration.body].velocity;
        match penetration.outcome {
            PenetrationOutcome::Moving => {
                self.outcome.still_moving += 1;
                self.outcome.unfinished.push(format!(
                    "{body} still moves in the target, v_z = {velocity:.4e}: a depth read now is not its last"
                ));
            }
            PenetrationOutcome::Through => {
                self.outcome.unfinished.push(format!(
                    "{body} has left the target through its back, v_z = {velocity:.4e}: it has no depth"
                ));
                self.outcome.exits.push(Exit { body, velocity });
            }
            PenetrationOutcome::AtRest | PenetrationOutcome::Ricochet | PenetrationOutcome::NotMet => {}
        }
    }

    fn report_in_space(&mut self, body: String, penetration: &Penetration) {
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
                    "{body} still moves in the target, speed {speed:.4e}: a depth read now is not its last"
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

/// The outcome of each body: of resistances that have ended, unless one in force has met the body since.
pub(super) fn latest_penetrations(ended: &[Penetration], in_force: Vec<Penetration>) -> Vec<Penetration> {
    let is_met = |p: &&Penetration| p.outcome != PenetrationOutcome::NotMet;
    let is_newer = |p: &Penetration| in_force.iter().filter(is_met).any(|other| other.body == p.body);
    let kept: Vec<Penetration> = ended.iter().filter(is_met).filter(|p| !is_newer(p)).copied().collect();
    let rest = in_force.iter().filter(|p| kept.iter().all(|other| other.body != p.body));
    kept.iter().chain(rest).copied().collect()
}
