//! Lockstep over LCM: the sensor answers `SIM_LINK_MOTION` of tick n with `SIM_TOOL_MOTION`, `SIM_TRUTH`,
//! `SENSOR_DEFLECTION` and, where it is due, `OBJECT_POSE` of n, and a repeated tick with the same bytes.

use lcmtypes::{Encoded, Lcm, Received, Woken};
use node::clock;
use node::lockstep::{Answer, Follower};
use node::problem::Problem;
use node::shell::{Flags, Shell};
use sensor_sim::SensorSim;
use spatial::ports::{LinkMotion, NodeStatus, Role, Stamp};

/// Run the node until a signal ends it.
pub(super) fn run(flags: &Flags, mut shell: Shell) -> anyhow::Result<Shell> {
    let (mut device, mut world) = (flags.device_link()?, flags.simulation_link()?);
    let links = world.subscribe::<LinkMotion>(16);
    let peers = device.subscribe::<NodeStatus>(16);
    let (device, world) = (shell.start_link(device)?, shell.start_link(world)?);
    let mut sensor = Sensor {
        follower: Follower::new(
            1,
            Stamp::lockstep(0, shell.scenario.timing.seed, Role::Robot).boot_id,
        ),
        simulation: None,
        answers: [const { None }; 4],
    };
    while shell.wait(None)? != Woken::Stopped {
        while let Some(Received { message, .. }) = peers.take() {
            shell.count(&[&device, &world]);
            shell.greet(&device, &message);
        }
        while let Some(Received { message, .. }) = links.take() {
            sensor.answer(&mut shell, &device, &world, &message);
        }
        shell.tell(&device);
    }
    Ok(shell)
}

struct Sensor {
    follower: Follower,
    simulation: Option<SensorSim>,
    /// What was answered to the last tick: the two device channels first.
    answers: [Option<Encoded>; 4],
}

impl Sensor {
    fn answer(&mut self, shell: &mut Shell, device: &Lcm, world: &Lcm, link: &LinkMotion) {
        if !shell.works() {
            return;
        }
        let expected = self.follower.expected_stamp();
        match self.follower.classify(link.stamp.step, link.stamp.boot_id) {
            Answer::Compute => {
                let started = clock::now();
                let scenario = &shell.scenario;
                let simulation = self
                    .simulation
                    .get_or_insert_with(|| SensorSim::new(scenario, &link.motion));
                let outputs = simulation.advance(link);
                self.answers = [
                    shell.publish(device, &outputs.deflections),
                    outputs.object_pose.and_then(|pose| shell.publish(device, &pose)),
                    shell.publish(world, &outputs.tool_motion),
                    shell.publish(world, &outputs.truth),
                ];
                shell.health.reach(link.stamp.step, clock::now() - started);
            }
            Answer::Repeat => {
                for (encoded, link) in self.answers.iter().zip([device, device, world, world]) {
                    if let Some(encoded) = encoded {
                        shell.repeat(link, encoded);
                    }
                }
            }
            Answer::Ignore => {}
            Answer::Broken => {
                shell.report(&Problem::Broken {
                    peer: Role::Robot,
                    expected,
                    found: link.stamp,
                });
            }
        }
    }
}
