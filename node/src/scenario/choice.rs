//! Keys whose value is one word out of a few.

use spatial::ports::Law;
use std::fmt::Debug;

/// What drives the nodes' time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimingMode {
    /// Simulated time, as fast as the machines go, deterministic.
    #[default]
    Lockstep,
    /// The wall clock: robot-sim paces the devices.
    Realtime,
}

/// From axis angles to the pose of s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kinematics {
    /// Six decoupled axes at the origin of s.
    #[default]
    Gantry,
    /// Six revolute joints in series, KUKA KR 16-2 class.
    Arm,
}

/// What joins an axis's motor and its link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gears {
    /// Nothing that yields: motor and link are one mass.
    #[default]
    Rigid,
    /// A spring and a damper each: the encoders see the motor, the tool hangs on the link.
    Elastic,
}

/// Which actual pose is taken to belong to a deflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pairing {
    /// The one at the deflection's sampling instant.
    #[default]
    Sampling,
    /// The one that arrived last.
    Arrival,
}

/// How deflections are carried between sensor and tcp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transform {
    /// As homogeneous transformations, footnotes 5 and 7, with the lever of the deflected tool.
    #[default]
    Exact,
    /// To first order, eqs. (7) and (8).
    Twist,
}

/// What a task is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TaskKind {
    /// Approach an object and press.
    #[default]
    Press,
    /// Reach a position within a tolerance, yielding to what is in the way.
    Position,
    /// Rest in tilted orientations, without contact, to learn what sensor and tool are.
    Calibrate,
}

/// What a step of a program does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StepKind {
    /// Move freely to a position.
    #[default]
    Move,
    /// Move down until the object is met.
    Approach,
    /// Press with a force for a time.
    Press,
    /// Stay, pressing or not, for a time.
    Hold,
    /// Press and move along a spiral until the tool sinks or nothing bears it.
    Search,
    /// Reach a depth within a tolerance, giving way sideways.
    Insert,
    /// Leave the object along the normal.
    Retract,
    /// Go on to the next workpiece: back to an earlier step, with an offset, until all are done.
    Next,
}

/// What follows a step that fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnFailure {
    /// A fault latches.
    #[default]
    Fault,
    /// The program goes on with its next retraction; without one a fault latches.
    Retract,
}

/// Where the object's pose is known from before the contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExpectedFrom {
    /// It is not: the impact is unexpected.
    #[default]
    Nothing,
    /// From a model: it is at rest at `task.expected_height_m`.
    Model,
    /// From the non-contact sensor.
    ObjectSensor,
}

/// How the object is assumed to move: what its model extrapolates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ObjectMotion {
    /// Not at all.
    #[default]
    Fixed,
    /// With a velocity that changes slowly.
    Steady,
    /// With an acceleration that changes slowly.
    Accelerated,
}

impl ObjectMotion {
    /// Degree of the polynomial in time.
    pub fn degree(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Steady => 1,
            Self::Accelerated => 2,
        }
    }
}

/// How the speed of the free motion changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// Such that neither tool nor gears swing afterwards, and the deflected tcp keeps to its path meanwhile.
    #[default]
    Smooth,
    /// With a constant acceleration, which begins and ends at once: what everything else is measured by.
    Trapezoid,
}

/// What a compliant sensor puts out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorOutput {
    /// Deflections.
    #[default]
    Deflection,
    /// Forces and moments, computed with the sensor's own calibration.
    Force,
}

/// What of the tool may touch the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToolShape {
    /// Its tcp.
    #[default]
    Point,
    /// The four corners of a rectangle around the tcp.
    Face,
    /// A cylinder along z whose end is centred at the tcp: a ring of points at its end, another one above.
    Peg,
}

/// A value that a scenario names by a word.
pub(super) trait Choice: Debug {
    /// The words to choose from.
    fn words(&self) -> &'static [&'static str];

    /// The word for this value; empty if a program set a value that no word stands for yet.
    fn word(&self) -> &'static str;

    /// Becomes the value that `word` stands for; `false`, and unchanged, if there is none.
    fn choose(&mut self, word: &str) -> bool;
}

/// The word that the scenario has for `choice`.
pub(super) fn word(choice: &impl Choice) -> &'static str {
    choice.word()
}

macro_rules! choice {
    ($type:ident: $($word:literal => $variant:ident),+) => {
        impl Choice for $type {
            fn words(&self) -> &'static [&'static str] {
                &[$($word),+]
            }

            fn word(&self) -> &'static str {
                let mut words = [$(($word, Self::$variant)),+].into_iter();
                words.find(|(_, value)| value == self).map_or("", |(word, _)| word)
            }

            fn choose(&mut self, word: &str) -> bool {
                match word {
                    $($word => *self = Self::$variant,)+
                    _ => return false,
                }
                true
            }
        }
    };
}

choice!(TimingMode: "lockstep" => Lockstep, "realtime" => Realtime);
choice!(Kinematics: "gantry" => Gantry, "arm" => Arm);
choice!(Gears: "rigid" => Rigid, "elastic" => Elastic);
choice!(Pairing: "sampling" => Sampling, "arrival" => Arrival);
choice!(Transform: "exact" => Exact, "twist" => Twist);
choice!(TaskKind: "press" => Press, "position" => Position, "calibrate" => Calibrate);
choice!(StepKind: "move" => Move, "approach" => Approach, "press" => Press, "hold" => Hold, "search" => Search,
    "insert" => Insert, "retract" => Retract, "next" => Next);
choice!(OnFailure: "fault" => Fault, "retract" => Retract);
choice!(ExpectedFrom: "nothing" => Nothing, "model" => Model, "object-sensor" => ObjectSensor);
choice!(ObjectMotion: "fixed" => Fixed, "steady" => Steady, "accelerated" => Accelerated);
choice!(Profile: "smooth" => Smooth, "trapezoid" => Trapezoid);
choice!(SensorOutput: "deflection" => Deflection, "force" => Force);
choice!(ToolShape: "point" => Point, "face" => Face, "peg" => Peg);
choice!(Law: "pd" => Pd, "pd-reset" => PdReset, "literal" => Literal, "proposed" => Proposed, "impedance" => Impedance,
    "elastic" => Elastic, "ros2" => Ros2, "fzi" => Fzi);
