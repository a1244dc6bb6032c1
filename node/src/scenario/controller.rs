//! The section `[controller]`: the control law, and what it assumes of robot, sensor, tool and object.

use super::check::{Conflicts, short};
use super::{
    Adaptation, AssumedGears, Collision, Cusum, ElasticLaw, ExpectedFrom, Law, Limits, ObjectMotion,
    Oscillation, Pairing, Scenario, SensorOutput, Shaping, Transform, schema,
};

schema::section! {
    /// The control law and what it assumes of robot, sensor and tool.
    Controller at "controller" with pd: Pd, proposed: Proposed, impedance: Impedance, ros2: Ros2, fzi: Fzi,
        expected: Expected, servo: AssumedServo, gears: AssumedGears, elastic: ElasticLaw, shaping: Shaping,
        adaptation: Adaptation, impact: Impact, cusum: Cusum, collision: Collision, oscillation: Oscillation, limits: Limits {
        /// Control law.
        law: Law = Law::Proposed;
        /// Which actual pose is taken to belong to a deflection.
        pairing: Pairing = Pairing::Sampling;
        /// How deflections are carried between sensor and tcp.
        transform: Transform = Transform::Exact;
        /// Which output of the sensor is used.
        sensor_output: SensorOutput = SensorOutput::Deflection;
        /// How long the deflection is averaged at standstill to become zero force.
        tare_s: f64 = 0.2, in 1e-3..=60.0;
        /// Assumed translational compliance of the sensor.
        compliance_m_per_n: f64 = 3.3333333333e-6, in 1e-9..=1e-2;
        /// Assumed rotational compliance of the sensor.
        compliance_rad_per_nm: f64 = 2.4933303e-3, in 1e-7..=10.0;
        /// Assumed tool centre point in s.
        tcp_in_s_m: [f64; 3] = [0.10, 0.0, -0.15], in -5.0..=5.0;
        /// Known mass of the tool, which a calibration needs if no wrench is measured; 0: not known.
        tool_mass_kg: f64 = 4.0, in 0.0..=1e4;
        /// Known centre of mass in s, which it needs too then; zero: not known.
        tool_centre_of_mass_in_s_m: [f64; 3] = [0.03, 0.0, -0.06], in -5.0..=5.0;
        /// Assumed corner of the sensor's low pass.
        sensor_bandwidth_hz: f64 = 200.0, in 1.0..=5000.0;
        /// Assumed periods T from a command to its effect.
        command_delay_periods: i64 = 2, in 0..=10;
        /// Assumed natural frequency of the robot's command filter.
        filter_frequency_hz: f64 = 15.0, in 0.1..=200.0;
        /// Assumed damping ratio of the robot's command filter.
        filter_damping: f64 = 0.8, in 0.1..=5.0;
        /// Assumed acceleration limit of each axis.
        acceleration_limit_rad_per_s2: [f64; 6] = [5.0, 5.0, 5.0, 30.0, 30.0, 30.0], in 0.01..=1e4;
        /// Normal force above which the tool counts as in contact.
        detection_threshold_n: f64 = 0.82, in 1e-3..=1e4;
        /// Force at the tcp per acceleration of the motion, by which that threshold is raised while the robot
        /// accelerates: the tool's inertia deflects the sensor too.
        apparent_mass_kg: f64 = 4.0, in 0.0..=1e5;
        /// How fast that rise fades: as long as tool and gears ring on.
        detection_fading_s: f64 = 0.2, in 1e-3..=10.0;
        /// Slow force that the sensor may show before contact, since the tare; beyond, its drift is published.
        drift_limit_n: f64 = 0.4, in 1e-3..=1e4;
        /// How old the newest sample may be before that is a fault; older ones are also no answer for a start.
        max_sensor_delay_s: f64 = 0.050, in 1e-3..=10.0;
        /// How long sensor or robot may bring nothing new before that is a fault; after 3 T the robot is held.
        stale_fault_s: f64 = 0.020, in 1e-3..=10.0;
        /// How many times heavier, or lighter, than tool_mass_kg the tool may look on its sensor before a start is refused.
        plausible_mass_ratio: f64 = 4.0, in 1.01..=1e3;
        /// How far the direction of what the sensor bears at rest may be from that of the known tool's weight, and from the
        /// axis about which that turns the sensor: farther, and the sensor's frame is not the configured one.
        plausible_turn_rad: f64 = 0.5, in 0.01..=1.5;
        /// Bias of the sensor, in N of its force along r's x and y, beyond which a start is refused.
        plausible_bias_n: f64 = 10.0, in 1e-3..=1e5;
        /// Over how long a parameter changed at run time is brought to its new value.
        slew_s: f64 = 0.2, in 1e-3..=10.0;
        /// Deviation from the desired force within which the force counts as settled.
        settled_band_n: f64 = 0.5, in 1e-3..=1e4;
        /// Time over which the tilt to the desired posture is spread after contact.
        tilt_time_s: f64 = 0.1, in 1e-3..=10.0;
        /// Bound of command minus actual position.
        max_lead_m: f64 = 0.003, in 1e-5..=1.0;
    }
}

schema::section! {
    /// The laws `pd` and `pd-reset`, eq. (1).
    Pd at "controller.pd" {
        /// Proportional gain K along an axis.
        proportional_m_per_n: f64 = 2.7e-6, in 0.0..=1e-2;
        /// Derivative gain D along an axis.
        derivative_m_per_n: f64 = 11e-6, in 0.0..=1e-2;
        /// Proportional gain K about an axis.
        proportional_rad_per_nm: f64 = 2.4e-4, in 0.0..=10.0;
        /// Derivative gain D about an axis.
        derivative_rad_per_nm: f64 = 1e-3, in 0.0..=10.0;
    }
}

schema::section! {
    /// The law `proposed`: eqs. (2) and (9) to (12) as an object model.
    Proposed at "controller.proposed" {
        /// Weight of a new sample in the object's pose, just after the contact.
        object_filter_gain: f64 = 0.1, in 1e-3..=1.0;
        /// The same later: the weight falls as in a mean over all samples, down to this one.
        settled_filter_gain: f64 = 0.01, in 1e-4..=1.0;
        /// How the object is assumed to move.
        object_motion: ObjectMotion = ObjectMotion::Fixed;
        /// Bandwidth of the reference model.
        reference_bandwidth_hz: f64 = 35.0, in 0.1..=200.0;
        /// Whether the desired force is fed forward as a disturbance of the position control.
        disturbance_feed_forward: bool = true;
    }
}

schema::section! {
    /// What is known of the object before the contact.
    Expected at "controller.expected" {
        /// Where it is known from.
        from: ExpectedFrom = ExpectedFrom::Nothing;
        /// How the object is assumed to move before the contact.
        object_motion: ObjectMotion = ObjectMotion::Steady;
        /// Weight of a new sample of the non-contact sensor.
        filter_gain: f64 = 0.03, in 1e-3..=1.0;
        /// How far above the expected object the approach has slowed down.
        search_margin_m: f64 = 0.0005, in 0.0..=0.1;
        /// Speed of the search from there on.
        search_speed_m_per_s: f64 = 0.002, in 1e-5..=1.0;
        /// Origin of the object's frame, seen from the tcp that touches it.
        object_in_tcp_m: [f64; 3] = [0.0, 0.0, 0.0], in -10.0..=10.0;
        /// Rotation vector from the tcp's orientation to the object's then.
        object_in_tcp_rad: [f64; 3] = [0.0, 0.0, 0.0], in -3.2..=3.2;
    }
}

schema::section! {
    /// What the controller assumes of the servos of the axes, `[robot]` as it is known from outside.
    AssumedServo at "controller.servo" {
        /// Gain of the position loop.
        position_gain_per_s: f64 = 25.0, in 0.1..=500.0;
        /// Bandwidth of the velocity loop, with the motor's inertia alone.
        velocity_bandwidth_hz: f64 = 60.0, in 1.0..=150.0;
        /// Integral time of the velocity loop.
        velocity_integral_time_s: f64 = 0.03, in 1e-3..=100.0;
        /// Inertia of each axis on the motor's side.
        motor_inertia_kg_m2: [f64; 6] = [120.0, 120.0, 120.0, 4.0, 4.0, 4.0], in 1e-3..=1e4;
        /// Inertia of each axis on the link's side.
        link_inertia_kg_m2: [f64; 6] = [60.0, 60.0, 60.0, 2.0, 2.0, 2.0], in 1e-3..=1e4;
    }
}

schema::section! {
    /// The law `impedance`: the way to the desired pose of `proposed` is that of a mass with damper and spring.
    Impedance at "controller.impedance" {
        /// Mass along an axis.
        mass_kg: f64 = 5.0, in 1e-3..=1e5;
        /// Damping along an axis.
        damping_ns_per_m: f64 = 840.0, in 0.0..=1e7;
        /// Stiffness along an axis towards where the object was met; 0: the desired force is reached.
        stiffness_n_per_m: f64 = 0.0, in 0.0..=1e9;
        /// Inertia about an axis.
        inertia_kg_m2: f64 = 0.06, in 1e-6..=1e5;
        /// Damping about an axis.
        damping_nms_per_rad: f64 = 10.0, in 0.0..=1e7;
        /// Stiffness about an axis.
        stiffness_nm_per_rad: f64 = 0.0, in 0.0..=1e9;
    }
}

schema::section! {
    /// The law `ros2`: that of ROS 2's `admittance_controller`, by default as it is published: low pass and damping of the
    /// joints as they are declared, the others along and about z and y as its tests set them.
    Ros2 at "controller.ros2" {
        /// Weight of a new sample in the filtered force, in each period.
        filter_gain: f64 = 0.05, in 1e-4..=1.0;
        /// Virtual mass along an axis.
        mass_kg: f64 = 7.7, in 1e-3..=1e5;
        /// Virtual stiffness along an axis, towards the reference.
        stiffness_n_per_m: f64 = 214.3, in 0.0..=1e9;
        /// Virtual inertia about an axis.
        inertia_kg_m2: f64 = 9.9, in 1e-6..=1e5;
        /// Virtual stiffness about an axis.
        stiffness_nm_per_rad: f64 = 214.5, in 0.0..=1e9;
        /// Damping ratio zeta, of which `D = 2 zeta sqrt(M K)`.
        damping_ratio: f64 = 2.828427, in 0.0..=1e4;
        /// Damping of the joints' velocities.
        joint_damping_per_s: f64 = 5.0, in 0.0..=200.0;
    }
}

schema::section! {
    /// The law `fzi`: that of FZI's `cartesian_force_controller`, by default as its example is shipped.
    Fzi at "controller.fzi" {
        /// How often it takes a step; in between its set-point is held.
        rate_hz: f64 = 100.0, in 1.0..=1000.0;
        /// Step of its virtual mass, whatever the rate.
        virtual_step_s: f64 = 0.02, in 1e-4..=1.0;
        /// Proportional gain p along an axis.
        proportional_translation: f64 = 0.05, in 0.0..=1e3;
        /// Proportional gain p about an axis.
        proportional_rotation: f64 = 1.5, in 0.0..=1e4;
        /// Derivative gain d.
        derivative_s: f64 = 0.0, in 0.0..=1e2;
        /// Scale s of the error.
        error_scale: f64 = 0.5, in 0.0..=1e3;
    }
}

schema::section! {
    /// What the controller's assessment of the impact assumes, eqs. (13) to (18), and that of the loop's margins; what is, is
    /// in `[tool]` and `[object]`.
    Impact at "controller.impact" {
        /// Assumed mass of the tool.
        tool_mass_kg: f64 = 4.0, in 1e-3..=1e4;
        /// Assumed principal moments of inertia of the tool about its centre of mass, along the axes of s.
        tool_inertia_kg_m2: [f64; 3] = [0.012, 0.016, 0.010], in 1e-7..=1e5;
        /// Assumed centre of mass of the tool in s.
        centre_of_mass_in_s_m: [f64; 3] = [0.03, 0.0, -0.06], in -5.0..=5.0;
        /// Assumed indentation coefficient c_in (for exponent n: N/m^n).
        indentation_n_per_m: f64 = 16e6, in 1e2..=1e12;
        /// Assumed exponent n of the indentation.
        exponent: f64 = 1.0, in 0.5..=2.0;
        /// Assumed rebound coefficient over indentation coefficient, c_re / c_in; 1 where it is unknown, as in (18): an
        /// elastic object, off which the tool bounces back faster than it came.
        rebound_ratio: f64 = 4.0, in 1.0..=1e3;
    }
}

impl Scenario {
    /// The servos that are assumed must be stable: `K_v / m (k + 1 / T_i) > k / T_i`, by Routh and Hurwitz, for
    /// `m s^3 + K_v s^2 + K_v (k + 1 / T_i) s + K_v k / T_i`.
    pub(super) fn check_servo(&self, conflicts: &mut Conflicts) {
        let servo = &self.controller.servo;
        let (k, integral) = (servo.position_gain_per_s, 1.0 / servo.velocity_integral_time_s);
        for i in 0..6 {
            let motor = servo.motor_inertia_kg_m2[i];
            let share = motor / (motor + servo.link_inertia_kg_m2[i]);
            let least = k * integral / (k + integral) / (share * std::f64::consts::TAU);
            conflicts.require(
                servo.velocity_bandwidth_hz > 1.5 * least,
                &[
                    "controller.servo.velocity_bandwidth_hz",
                    "controller.servo.position_gain_per_s",
                    "controller.servo.velocity_integral_time_s",
                    "controller.servo.motor_inertia_kg_m2",
                    "controller.servo.link_inertia_kg_m2",
                ],
                format!(
                    "controller.servo.velocity_bandwidth_hz is {} Hz, too little for axis {i}, whose servo would swing up: \
                     choose more than {} Hz, or a smaller position gain",
                    short(servo.velocity_bandwidth_hz),
                    short(1.5 * least)
                ),
            );
        }
    }
}
