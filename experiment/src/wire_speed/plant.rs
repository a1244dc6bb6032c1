//! Robot and sensor, in this process, as the controller sees them.

use lcmtypes::{Encoded, Message};
use node::scenario::Scenario;
use robot_sim::RobotSim;
use sensor_sim::SensorSim;
use spatial::ports::{Command, Invalid, ToolMotion};

/// Both simulators, between two cycles.
pub(super) struct Plant {
    robot: RobotSim,
    sensor: SensorSim,
    /// Of the tick of the last cycle.
    tool: Option<ToolMotion>,
}

/// What robot and sensor say to the controller in a cycle.
pub(super) struct Said {
    pub(super) tick: i64,
    pub(super) state: Encoded,
    /// Where it is due.
    pub(super) object_pose: Option<Encoded>,
    pub(super) deflection: Encoded,
}

impl Plant {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let robot = RobotSim::new(scenario);
        let sensor = SensorSim::new(scenario, &robot.link_motion().motion);
        Self {
            robot,
            sensor,
            tool: None,
        }
    }

    /// Go on to the next cycle; `command` answers the one before.
    pub(super) fn go_on(&mut self, command: Option<&Command>) -> Result<Said, Invalid> {
        if let Some(tool) = self.tool.take() {
            self.robot.advance(&tool, command);
        }
        while !self.robot.command_due() {
            let sensed = self.sensor.advance(&self.robot.link_motion());
            self.robot.advance(&sensed.tool_motion, None);
        }
        let sensed = self.sensor.advance(&self.robot.link_motion());
        self.tool = Some(sensed.tool_motion);
        Ok(Said {
            tick: self.robot.tick(),
            state: self.robot.state().encode()?,
            object_pose: sensed.object_pose.map(|pose| pose.encode()).transpose()?,
            deflection: sensed.deflections.encode()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::in_process;
    use crate::scenarios::Source;

    #[test]
    fn the_controller_sees_what_it_sees_in_the_loop() {
        let changes = ["timing.duration_s=0.9".to_owned()];
        let scenario = Source::find("expected").unwrap().scenario(&changes).unwrap();
        let mut plant = Plant::new(&scenario);
        let (mut command, mut cycles) = (None, 0);
        in_process::run(&scenario, |tick| {
            let Some(answer) = tick.controller else { return };
            let said = plant.go_on(command.as_ref()).unwrap();
            assert_eq!(said.tick, tick.link_motion.stamp.step);
            assert_eq!(said.state, tick.robot_state.unwrap().encode().unwrap());
            assert_eq!(said.deflection, tick.sensor.deflections.encode().unwrap());
            let pose = tick.sensor.object_pose.map(|pose| pose.encode().unwrap());
            assert_eq!(said.object_pose, pose);
            (command, cycles) = (Some(answer.command), cycles + 1);
        });
        assert_eq!(cycles, 226);
    }
}
