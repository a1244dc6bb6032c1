//! What the tool that hangs on the sensor does to the links, by statics.

use super::elastic::hanging;
use super::*;
use spatial::kinematics::{join, split};

/// The default gantry with s turned by 0.2 rad about x and -0.15 rad about y, at rest, and where s is.
fn tilted(scenario: &Scenario) -> (Dynamics, State, Motion) {
    let dynamics = Dynamics::new(scenario);
    let axes = join(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.2, -0.15, 0.0));
    let link = Motion::at_rest(dynamics.kinematics.forward(&axes));
    (dynamics, State::at_rest(axes), link)
}

/// Force (N) and moment (Nm) about s that act on the links of inertia 180 kg and 6 kg m^2 besides the motors.
fn reaction(dynamics: &Dynamics, state: &State, tool: &Motion) -> (Vector3<f64>, Vector3<f64>) {
    let motion = dynamics.link_motion(state, &dynamics.posture(state), &Axes::zeros(), tool);
    let jacobian = dynamics.kinematics.jacobian(&state.link_position);
    let acceleration = join(motion.acceleration, motion.angular_acceleration);
    // q'' from the motion of s, and J^-T from the axes' torque to the wrench.
    let changes = jacobian.lu().solve(&acceleration).unwrap();
    let inertia = Axes::new(180.0, 180.0, 180.0, 6.0, 6.0, 6.0);
    let torque = changes.component_mul(&inertia);
    split(&jacobian.transpose().lu().solve(&torque).unwrap())
}

/// PLANT.md section 2: the tool's static weight is compensated, however the link is turned.
#[test]
fn a_tool_at_rest_on_a_tilted_link_does_not_act_on_it() {
    let scenario = Scenario::default();
    let (dynamics, state, link) = tilted(&scenario);
    let (force, moment) = reaction(&dynamics, &state, &hanging(&scenario, &link, &Vector3::zeros()));
    assert!(force.norm() < 1e-9 && moment.norm() < 1e-9, "{force} {moment}");
}

/// A force at the tcp of a tool at rest reaches the link as it is, with its moment about s; and so does the weight
/// beyond its compensation, which takes it at `R c` from s.
#[test]
fn a_force_on_the_tool_reaches_a_tilted_link_with_its_sign() {
    let scenario = Scenario::default();
    let (dynamics, state, link) = tilted(&scenario);
    let weight = Vector3::new(0.0, 0.0, -scenario.tool.mass_kg * spatial::GRAVITY_M_PER_S2);
    for pressed in [
        Vector3::new(0.0, 0.0, 10.0),
        Vector3::new(10.0, 0.0, 0.0),
        Vector3::new(3.0, -8.0, 5.0),
    ] {
        let tool = hanging(&scenario, &link, &pressed);
        let (force, moment) = reaction(&dynamics, &state, &tool);
        let sag = tool.pose.translation.vector - link.pose.translation.vector;
        let tcp = sag + tool.pose.rotation * Vector3::from(scenario.tool.tcp_in_s_m);
        let expected = tcp.cross(&pressed) + sag.cross(&weight);
        assert!((force - pressed).norm() < 1e-9, "{force} N of {pressed} N");
        assert!((moment - expected).norm() < 1e-9, "{moment} Nm of {expected} Nm");
        assert!(expected.norm() > 0.5);
    }
}

/// A plate that moves drags the link along: the damper's force acts at s', not at s.
#[test]
fn a_moving_plate_drags_the_link_along_at_its_own_place() {
    let scenario = Scenario::default();
    let (dynamics, state, link) = tilted(&scenario);
    let still = hanging(&scenario, &link, &Vector3::new(200.0, 0.0, 0.0));
    let mut moving = still;
    moving.velocity = Vector3::new(0.1, 0.2, -0.3);
    let (before, now) = (
        reaction(&dynamics, &state, &still),
        reaction(&dynamics, &state, &moving),
    );
    let dragged = moving.velocity * scenario.sensor.damping_ns_per_m;
    let arm = still.pose.translation.vector - link.pose.translation.vector;
    assert!((now.0 - before.0 - dragged).norm() < 1e-9);
    assert!((now.1 - before.1 - arm.cross(&dragged)).norm() < 1e-9);
    assert!(arm.cross(&dragged).norm() > 0.01);
}
