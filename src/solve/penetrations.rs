//! What a run reports at its end of bodies in targets that are not meshed.
//! Never here: resistances.

use super::outcome::{Exit, PenetrationSummary};
use super::run::Run;
use crate::load::{Penetration, PenetrationOutcome};

impl Run<'_> {
    /// At the end: what has become of bodies in targets.
    pub(super) fn report_penetrations(&mut self) {
        let in_force = self.loads.iter().flat_map(|load| load.penetrations(&self.dofs)).collect();
        let all = self.ended.beside(in_force);
        for penetration in all {
            let name = self.plan.bodies[penetration.body].name.clone();
            match penetration.in_space {
                None => self.report_along_z(name, &penetration),
                Some(_) => self.report_in_space(name, &penetration),
            }
        }
    }

    fn report_along_z(&mut self, body: String, penetration: &Penetration) {
        let velocity = self.dofs.bodies[penetration.body].velocity;
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
