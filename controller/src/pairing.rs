//! Which actual pose belongs to which deflection: paired by sampling time, never by arrival.
//!
//! Paper, below (2): that force and pose belong to the same instant is an assumption there; here it is made true. (PLANT.md: without it a sensor delay of 32 ms costs 380 instead of 98 ms.)

use spatial::TICK_US;
use spatial::kinematics::Axes;
use spatial::ports::{DeflectionSample, RobotState};

/// How far back the encoders are remembered, ticks: the largest sensor delay, and the group delay of its filter.
const LENGTH: usize = 256;

/// Encoder readings of the recent past, one tick apart.
#[derive(Clone, Debug)]
pub struct EncoderHistory {
    ring: [Axes; LENGTH],
    /// Where the newest reading is.
    head: usize,
    /// Sampling instant of the newest reading, us; `None`: none yet.
    newest_utime: Option<i64>,
    /// How many are known.
    count: usize,
}

impl Default for EncoderHistory {
    fn default() -> Self {
        Self {
            ring: [Axes::zeros(); LENGTH],
            head: 0,
            newest_utime: None,
            count: 0,
        }
    }
}

impl EncoderHistory {
    /// Remember what `state` brings that is new. A gap (a lost state, a period of more ticks than there are readings in a
    /// message) is bridged by a cubic that goes on as the readings before and after it do.
    pub fn update(&mut self, state: &RobotState) {
        let samples = usize::try_from(state.sample_count)
            .unwrap_or(1)
            .clamp(1, state.axis_position.len());
        for age in (0..samples).rev() {
            let axes = state.axis_position[age];
            let onwards = age.checked_sub(1).map(|next| state.axis_position[next] - axes);
            self.push(state.stamp.utime - age as i64 * TICK_US, axes, onwards);
        }
    }

    /// The axes at `utime` (us), linear between the two neighbouring readings; the oldest or newest one outside.
    pub fn at(&self, utime: f64) -> Axes {
        let Some(newest) = self.newest_utime else {
            return Axes::zeros();
        };
        let age = ((newest as f64 - utime) / TICK_US as f64).clamp(0.0, (self.count - 1) as f64);
        let whole = libm::floor(age);
        let (younger, older) = (
            self.aged(whole as usize),
            self.aged((whole as usize + 1).min(self.count - 1)),
        );
        younger + (older - younger) * (age - whole)
    }

    /// Whether there is a reading for `utime` (us): half a tick beyond the newest one there is none.
    pub fn reach(&self, utime: f64) -> bool {
        self.newest_utime
            .is_some_and(|newest| utime - newest as f64 <= 0.5 * TICK_US as f64)
    }

    /// The newest axes, whenever they were read: what a controller without time stamps would use.
    pub fn newest(&self) -> Axes {
        self.aged(0)
    }

    /// One reading, from which the axes go `onwards` in the next tick, if that is known.
    fn push(&mut self, utime: i64, axes: Axes, onwards: Option<Axes>) {
        let missing = match self.newest_utime {
            None => 1,
            Some(newest) => (utime - newest) / TICK_US,
        };
        if missing <= 0 {
            return;
        }
        let last = if self.count == 0 { axes } else { self.aged(0) };
        // Hermite's cubic over the gap is the straight line, and what the ends' slopes differ from it.
        let way = axes - last;
        let differs = |per_tick: Axes| per_tick * missing as f64 - way;
        let at_last = match self.count {
            ..2 => Axes::zeros(),
            _ => differs(last - self.aged(1)),
        };
        let at_axes = onwards.map_or(Axes::zeros(), differs);
        let shift = usize::try_from(missing).unwrap_or(LENGTH).min(LENGTH);
        for age in (0..shift).rev() {
            let left = age as f64 / missing as f64;
            let gone = 1.0 - left;
            let bent = (at_last * left - at_axes * gone) * (left * gone);
            self.head = (self.head + 1) % LENGTH;
            self.ring[self.head] = axes - way * left + bent;
        }
        self.count = (self.count + shift).min(LENGTH);
        self.newest_utime = Some(utime);
    }

    fn aged(&self, age: usize) -> Axes {
        self.ring[(self.head + LENGTH - age) % LENGTH]
    }
}

/// How many samples wait for their encoder readings at most: those of the longest silence of the robot that is no fault.
const WAITING: usize = 64;

/// Samples of the sensor that have come before the encoder readings of their instant, the oldest first.
#[derive(Clone, Debug)]
pub struct Waiting {
    ring: [DeflectionSample; WAITING],
    first: usize,
    count: usize,
}

impl Default for Waiting {
    fn default() -> Self {
        Self {
            ring: [DeflectionSample::default(); WAITING],
            first: 0,
            count: 0,
        }
    }
}

impl Waiting {
    /// Let `sample` wait behind the others; where too many do, the oldest one goes.
    pub fn push(&mut self, sample: &DeflectionSample) {
        if self.count == WAITING {
            self.go_on();
        }
        self.ring[(self.first + self.count) % WAITING] = *sample;
        self.count += 1;
    }

    /// The sample that has waited longest.
    pub fn oldest(&self) -> Option<DeflectionSample> {
        (self.count > 0).then(|| self.ring[self.first])
    }

    /// The oldest sample waits no longer.
    pub fn go_on(&mut self) {
        if self.count > 0 {
            self.first = (self.first + 1) % WAITING;
            self.count -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::ports::{Authenticity, ClockEcho, ENCODER_SAMPLES, Fault, RobotMode, Stamp};

    /// A state at `tick` of a robot whose axes all stand at 10 times the tick.
    fn state(tick: i64) -> RobotState {
        RobotState {
            stamp: Stamp {
                step: tick,
                utime: tick * TICK_US,
                boot_id: 1,
            },
            sample_count: (tick + 1).min(ENCODER_SAMPLES as i64) as i32,
            axis_position: std::array::from_fn(|age| Axes::repeat(10.0 * (tick - age as i64).max(0) as f64)),
            axis_velocity: Axes::zeros(),
            axis_setpoint: Axes::zeros(),
            mode: RobotMode::Idle,
            fault: Fault::None,
            fault_axis: -1,
            command_step: -1,
            missed_commands: 0,
            echo: ClockEcho::default(),
            authenticity: Authenticity::default(),
        }
    }

    #[test]
    fn readings_are_found_at_and_between_their_instants() {
        let mut history = EncoderHistory::default();
        for tick in (0..=40).step_by(4) {
            history.update(&state(tick));
        }
        assert_eq!(history.at(37_000.0).x, 370.0);
        assert_eq!(history.at(36_250.0).x, 362.5);
        assert_eq!(history.at(99_000.0).x, 400.0);
        assert_eq!(history.at(-5_000.0).x, 0.0);
    }

    #[test]
    fn a_reading_is_there_or_not() {
        let mut history = EncoderHistory::default();
        assert!(!history.reach(0.0));
        history.update(&state(8));
        assert!(history.reach(8_400.0) && !history.reach(8_600.0));
    }

    #[test]
    fn samples_wait_in_their_order_and_the_oldest_go() {
        let mut waiting = Waiting::default();
        let sample = |utime| DeflectionSample {
            utime,
            ..DeflectionSample::default()
        };
        for utime in 0..70 {
            waiting.push(&sample(utime));
        }
        for utime in 6..70 {
            assert_eq!(waiting.oldest().map(|it| it.utime), Some(utime));
            waiting.go_on();
        }
        assert_eq!(waiting.oldest(), None);
    }

    #[test]
    fn a_lost_state_is_bridged() {
        let mut history = EncoderHistory::default();
        history.update(&state(0));
        history.update(&state(20));
        assert_eq!(history.at(6_000.0).x, 60.0);
        assert_eq!(history.at(15_500.0).x, 155.0);
    }

    /// With T = 12 ms every third reading is in no message. A vibration of 1 mm at 14 Hz, with accelerations of 8 m/s^2,
    /// is known there within 5 um; a straight line would miss it by 25 um, which look like 0.9 N.
    #[test]
    fn a_vibration_is_known_between_the_messages() {
        let way = |tick: i64| 1e-3 * libm::sin(std::f64::consts::TAU * 14e-3 * tick as f64);
        let mut history = EncoderHistory::default();
        for tick in (0..=120).step_by(12) {
            let axis_position = std::array::from_fn(|age| Axes::repeat(way(tick - age as i64)));
            history.update(&RobotState {
                axis_position,
                ..state(tick)
            });
        }
        for tick in 13..=120 {
            let error = history.at(1e3 * tick as f64).x - way(tick);
            assert!(error.abs() < 5e-6, "{error} at {tick}");
        }
    }
}
