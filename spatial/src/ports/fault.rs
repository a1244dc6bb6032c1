//! Why a node does not go on.

use super::wire_enum;

wire_enum! {
    /// Why a node does not go on. The first cause is latched.
    Fault {
        /// No fault.
        #[default]
        None = 0,
        /// A tick was skipped or a peer restarted in lockstep.
        LockstepBroken = 1,
        /// A peer did not answer in lockstep.
        PeerSilent = 2,
        /// A peer runs with another configuration, seed, T or protocol.
        HelloMismatch = 3,
        /// A command is not finite.
        CommandInvalid = 4,
        /// Commands were missing for longer than `command_gap_s`.
        CommandGap = 5,
        /// The sensor is silent or too old.
        SensorStale = 6,
        /// The robot's state is silent or too old.
        StateStale = 7,
        /// The simulated world died.
        SimLost = 8,
        /// An axis is at the end of its range.
        AxisLimit = 9,
        /// An axis exceeds its velocity limit.
        VelocityLimit = 10,
        /// A pose that kinematics can't reach.
        Unreachable = 11,
        /// The deflection is at the end of its range.
        DeflectionSaturated = 12,
        /// The contact force exceeds its limit.
        ForceLimit = 13,
        /// Contact where none is allowed.
        Collision = 14,
        /// No object within the search depth.
        NoContact = 15,
        /// A clock jumped.
        ClockJump = 16,
        /// A message of a peer can't be used.
        MessageInvalid = 17,
        /// Another node commands the robot.
        SecondOwner = 18,
        /// A log can't be written.
        RecordFailed = 19,
        /// The tool yields by more than the tolerance of its position.
        ToleranceExceeded = 20,
        /// A step of a program has not come to its end in time.
        StepTimeout = 21,
    }
}
