//! What is asked for over `TASK` while the controller runs, on the simulated plant: stops, parameters, starts.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod parameters;
mod starts;
mod stops;

use experiment::in_process::{self, Tick};
use experiment::scenarios::Source;
use node::scenario::Scenario;
use spatial::kinematics::Axes;
use spatial::ports::{ControllerStatus, Stamp, Task, TaskAction, TaskParameters};

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<_> = overrides.iter().map(|&text| text.to_owned()).collect();
    Source::find(name).unwrap().scenario(&overrides).unwrap()
}

/// The `count`-th request, for the first cycle from `tick` on.
fn ask(count: i64, tick: i64, action: TaskAction) -> Task {
    Task {
        stamp: Stamp {
            step: count,
            utime: tick * spatial::TICK_US,
            boot_id: 1,
        },
        action,
        ..Task::default()
    }
}

/// The first request: another value of parameter `i`.
fn change(tick: i64, i: usize, value: f64) -> Task {
    let mut values = [None; TaskParameters::COUNT];
    values[i] = Some(value);
    Task {
        parameters: TaskParameters::from_values(values),
        ..ask(1, tick, TaskAction::None)
    }
}

/// What is said in a run with `tasks`.
struct Said {
    /// Tick and first set-point of each cycle.
    set_points: Vec<(i64, Axes)>,
    /// Tick and encoder values of each cycle.
    encoders: Vec<(i64, Axes)>,
    statuses: Vec<ControllerStatus>,
    /// True contact force along z by tick, N.
    force_n: Vec<f64>,
    /// True position of the tcp by tick, m.
    tcp_m: Vec<nalgebra::Vector3<f64>>,
}

impl Said {
    fn of(scenario: &Scenario, tasks: &[Task]) -> Self {
        let mut said = Self {
            set_points: Vec::new(),
            encoders: Vec::new(),
            statuses: Vec::new(),
            force_n: Vec::new(),
            tcp_m: Vec::new(),
        };
        in_process::run_with(scenario, tasks, |tick: &Tick| {
            let truth = &tick.sensor.truth;
            said.force_n.push(truth.contact_force.z);
            said.tcp_m.push(truth.tcp_pose.translation.vector);
            if let Some(state) = &tick.robot_state {
                said.encoders.push((state.stamp.step, state.axis_position[0]));
            }
            if let Some(outputs) = &tick.controller {
                said.set_points
                    .push((truth.stamp.step, outputs.command.axis_position[0]));
                said.statuses.push(outputs.status);
            }
        });
        said
    }

    fn status_at(&self, tick: i64) -> &ControllerStatus {
        self.statuses
            .iter()
            .find(|status| status.stamp.step >= tick)
            .unwrap()
    }

    /// The largest acceleration of the motors, over two cycles, from `tick` on, along the axes of translation and of rotation
    /// of a gantry, rad/s^2.
    fn acceleration_from(&self, tick: i64, period_s: f64) -> [f64; 2] {
        let after = self.encoders.windows(3).filter(|it| it[2].0 >= tick);
        let change = |it: &[(i64, Axes)]| (it[2].1 - it[1].1 * 2.0 + it[0].1) / (period_s * period_s);
        after.map(change).fold([0.0, 0.0], |[a, b], it| {
            [
                a.max(it.fixed_rows::<3>(0).amax()),
                b.max(it.fixed_rows::<3>(3).amax()),
            ]
        })
    }
}
