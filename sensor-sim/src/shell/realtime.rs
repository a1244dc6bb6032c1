//! Real time: the simulated world is in lockstep with robot-sim all the same; the sensor's samples carry the own clock.
//!
//! After a restart, of this node or of robot-sim, the tool is at rest again: hanging, or pressing where it was pressed.

use super::offset::Offset;
use lcmtypes::{Encoded, Lcm, Received, Woken};
use node::clock;
use node::lockstep::{Answer, Follower};
use node::shell::{Flags, RealTime, Shell};
use sensor_sim::{Outputs, SensorSim};
use spatial::TICK_US;
use spatial::ports::{Command, LinkMotion, NodeStatus, Role};
use std::time::Instant;

/// The world as this side of it knows it.
struct World {
    /// The process that it goes on with.
    master: i64,
    follower: Follower,
    simulation: SensorSim,
    offset: Offset,
    /// What was answered to the last tick: the two device channels first.
    answers: [Option<Encoded>; 4],
}

/// Run the node until a signal ends it.
pub(super) fn run(flags: &Flags, mut node: RealTime) -> anyhow::Result<Shell> {
    let (mut device, mut world) = (flags.device_link()?, flags.simulation_link()?);
    let links = world.subscribe::<LinkMotion>(16);
    let commands = device.subscribe::<Command>(64);
    let peers = device.subscribe::<NodeStatus>(64);
    let (device, world) = (node.shell.start_link(device)?, node.shell.start_link(world)?);
    let mut sensor: Option<World> = None;
    loop {
        node.keep_status(&device, &[&device, &world]);
        let pause = node.status_due().saturating_duration_since(clock::now());
        if node.shell.wait(Some(pause))? == Woken::Stopped {
            break;
        }
        while let Some(Received { message, .. }) = peers.take() {
            node.hear(&message);
        }
        while let Some(Received { message, received_at }) = commands.take() {
            if node.admits(&message) {
                node.take_echo(&message, received_at);
            }
        }
        while let Some(Received { message, received_at }) = links.take() {
            answer(&mut sensor, &mut node, [&device, &world], &message, received_at);
        }
    }
    Ok(node.shell)
}

/// Answer the robot's half of the physics with this side's, as far as it is of the robot that is worked with.
fn answer(
    sensor: &mut Option<World>,
    node: &mut RealTime,
    [device, world]: [&Lcm; 2],
    link: &LinkMotion,
    received_at: Instant,
) {
    let (tick, master) = (link.stamp.step, link.stamp.boot_id);
    if !node.works_with(Role::Robot, master) {
        return;
    }
    let known = sensor.take().filter(|known| known.master == master);
    let known = sensor.insert(known.unwrap_or_else(|| World {
        master,
        // It joins at whatever tick the robot is.
        follower: Follower::starting_at(tick, 1, master),
        simulation: SensorSim::joining(&node.shell.scenario, link),
        offset: Offset::default(),
        answers: [const { None }; 4],
    }));
    let ahead_us = known.offset.take(link.stamp.utime, node.utime(received_at));
    match known.follower.classify(tick, master) {
        Answer::Compute => {
            let outputs = known.simulation.advance(link);
            known.answers = publish(node, [device, world], link, &outputs, ahead_us);
            node.shell.health.reach(tick, clock::now() - received_at);
        }
        Answer::Repeat => {
            for (encoded, link) in known.answers.iter().zip([device, device, world, world]) {
                if let Some(encoded) = encoded {
                    node.shell.repeat(link, encoded);
                }
            }
        }
        // The robot waits for its answers: none of its ticks can be skipped.
        Answer::Ignore | Answer::Broken => {}
    }
}

/// Publish what a tick brings, with the own clock's stamps.
fn publish(
    node: &mut RealTime,
    [device, world]: [&Lcm; 2],
    link: &LinkMotion,
    outputs: &Outputs,
    ahead_us: i64,
) -> [Option<Encoded>; 4] {
    let tick = link.stamp.step;
    // From simulated time to the own clock.
    let own = |utime: i64| utime - tick * TICK_US + link.stamp.utime + ahead_us;
    let mut stamp = node.stamp(tick, clock::now());
    stamp.utime = own(tick * TICK_US);
    let mut deflections = outputs.deflections;
    for sample in &mut deflections.samples {
        sample.utime = own(sample.utime);
    }
    deflections.stamp = stamp;
    deflections.stamp.utime = deflections.samples[0].utime;
    deflections.echo = node.echo();
    let object_pose = outputs.object_pose.map(|mut pose| {
        pose.stamp.utime = own(pose.stamp.utime);
        pose.stamp.boot_id = stamp.boot_id;
        pose
    });
    let (mut tool_motion, mut truth) = (outputs.tool_motion, outputs.truth);
    (tool_motion.stamp, truth.stamp) = (stamp, stamp);
    [
        node.publish(device, &deflections),
        object_pose.and_then(|pose| node.shell.publish(device, &pose)),
        node.shell.publish(world, &tool_motion),
        node.shell.publish(world, &truth),
    ]
}
