//! The whole of the paper's Fig. 2 as one readable loop, in one process and without a network.
//!
//! The three programs in lockstep reproduce it bit for bit. They repeat what is lost; here it is lost for good
//! (`network.loss_ratio`).

use crate::network::Network;
use controller::Controller;
use controller::agenda::Agenda;
use node::scenario::Scenario;
use robot_sim::RobotSim;
use sensor_sim::SensorSim;
use spatial::ports::{LinkMotion, RobotState, Task};
use std::hint::black_box;

/// All that is said within one tick.
#[derive(Clone, Copy, Debug)]
pub struct Tick {
    /// The robot's half of the physics.
    pub link_motion: LinkMotion,
    /// The robot's state, at multiples of T.
    pub robot_state: Option<RobotState>,
    /// What the sensor's side answers.
    pub sensor: sensor_sim::Outputs,
    /// What the controller answers, at multiples of T.
    pub controller: Option<controller::Outputs>,
}

/// Run `scenario` and show each tick to `observe`.
///
/// The loop's margins are not assessed, on which nothing else depends: that takes a fifth of the time of such a run, with the law
/// `elastic` more than all of it.
pub fn run(scenario: &Scenario, observe: impl FnMut(&Tick)) {
    run_loop(scenario, &[], false, observe);
}

/// All that the three programs do and say, with `tasks`, each of which the first cycle at or after its `utime` follows.
pub fn run_with(scenario: &Scenario, tasks: &[Task], observe: impl FnMut(&Tick)) {
    run_loop(scenario, tasks, true, observe);
}

fn run_loop(scenario: &Scenario, tasks: &[Task], assesses: bool, mut observe: impl FnMut(&Tick)) {
    let mut agenda = Agenda::default();
    for task in tasks {
        agenda.add(task);
    }
    let mut robot = RobotSim::new(scenario);
    let mut sensor = SensorSim::new(scenario, &robot.link_motion().motion);
    let mut controller = Controller::new(scenario);
    let mut network = Network::new(scenario);
    for _ in 0..scenario.timing.ticks() {
        let link_motion = robot.link_motion();
        let robot_state = robot.command_due().then(|| robot.state());
        let sensed = sensor.advance(&link_motion);
        let answer = network.take(robot_state, &sensed).map(|(tick, arrived)| {
            if let Some(task) = agenda.due(tick) {
                controller.request(&task);
            }
            controller.cycle(&arrived.heard(tick))
        });
        observe(&Tick {
            link_motion,
            robot_state,
            sensor: sensed,
            controller: answer,
        });
        if assesses && answer.is_some() {
            controller.assess();
        }
        let command = network.passes(answer.map(|answer| answer.command));
        robot.advance(&sensed.tool_motion, command.as_ref());
    }
}

/// One of the loop's parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The robot's half of the physics, with its servos.
    Robot,
    /// The sensor's half, with its signal chain.
    Sensor,
    /// The controller.
    Controller,
}

/// Run one part of `scenario` alone, on what the others have said in `ticks`: a run from its start.
pub fn replay(part: Part, scenario: &Scenario, ticks: &[Tick]) {
    match part {
        Part::Robot => {
            let mut robot = RobotSim::new(scenario);
            let network = Network::new(scenario);
            for tick in ticks {
                black_box(robot.link_motion());
                black_box(robot.command_due().then(|| robot.state()));
                let command = network.passes(tick.controller.map(|answer| answer.command));
                robot.advance(&tick.sensor.tool_motion, command.as_ref());
            }
        }
        Part::Sensor => {
            let Some(first) = ticks.first() else { return };
            let mut sensor = SensorSim::new(scenario, &first.link_motion.motion);
            for tick in ticks {
                black_box(sensor.advance(&tick.link_motion));
            }
        }
        Part::Controller => replay_cycles(scenario, ticks, |cycle| cycle()),
    }
}

/// Run the controller of `scenario` alone, as [`replay`], and let `around` run each of its cycles.
pub fn replay_cycles(scenario: &Scenario, ticks: &[Tick], mut around: impl FnMut(&mut dyn FnMut())) {
    let mut controller = Controller::new(scenario);
    let mut network = Network::new(scenario);
    for tick in ticks {
        if let Some((tick, arrived)) = network.take(tick.robot_state, &tick.sensor) {
            around(&mut || {
                black_box(controller.cycle(&arrived.heard(tick)));
            });
        }
    }
}
