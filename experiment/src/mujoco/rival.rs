//! MuJoCo in a process of its own.

use nalgebra::Vector3;
use node::scenario::{Scenario, ScenarioError};
use sensor_sim::tool::{Body, State};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use spatial::{GRAVITY_M_PER_S2, TICK_S};
use std::f64::consts::TAU;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The other half: builds the model and runs it.
const SCRIPT: &str = include_str!("tool.py");
/// The object's mass, kg: a force of 100 N accelerates it by less than what rounding does.
const OBJECT_KG: f64 = 1e9;
/// From the object's surface to where the tendon hangs, m: where the tcp goes sideways by 1 mm it lengthens by 0.5 nm.
const FAR_M: f64 = 1000.0;

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum MujocoError {
    /// The scenario can't be changed to one with an object that swings.
    #[error("{0}")]
    Scenario(#[from] ScenarioError),
    /// Python can't be started.
    #[error("can't start {}: {source}; name a Python that has the package mujoco by --python", path.display())]
    Start {
        /// The interpreter.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It has ended, or does not say what it should.
    #[error("MuJoCo's process does not answer: {0}; stderr tells what became of it")]
    Answer(io::Error),
    /// No step is short enough.
    #[error(
        "MuJoCo's {integrator} errs by {error_m:.1e} m, more than {wanted_m:.1e} m, even in steps of {step_s:.1e} s; \
         raise sensor.integration_step_s"
    )]
    Coarse {
        /// Which.
        integrator: &'static str,
        /// Its shortest step, s.
        step_s: f64,
        /// Its error, m.
        error_m: f64,
        /// The error that was wanted, m.
        wanted_m: f64,
    },
}

/// A process that has a model.
pub(super) struct Rival {
    child: Child,
    stdin: ChildStdin,
    stdout: BufReader<ChildStdout>,
}

#[derive(Serialize)]
struct Run<'a> {
    integrator: &'a str,
    steps_per_tick: usize,
    ticks: usize,
    /// Whether to tell where the tcp is after each tick, instead of how long it took.
    trace: bool,
}

#[derive(Deserialize)]
struct Ran {
    core_s: f64,
    tcp_m: Vec<[f64; 3]>,
}

impl Rival {
    /// Start `python` with a [`model`].
    pub(super) fn start(python: &Path, model: &Value) -> Result<Self, MujocoError> {
        let start = |source| MujocoError::Start {
            path: python.to_owned(),
            source,
        };
        let mut child = Command::new(python)
            .args(["-c", SCRIPT])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(start)?;
        let (Some(stdin), Some(stdout)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(MujocoError::Answer(io::ErrorKind::BrokenPipe.into()));
        };
        let mut rival = Self {
            child,
            stdin,
            stdout: BufReader::new(stdout),
        };
        rival.tell(model)?;
        Ok(rival)
    }

    /// Where the tcp is after each tick, m in r.
    pub(super) fn trace(
        &mut self,
        integrator: &str,
        steps_per_tick: usize,
        ticks: usize,
    ) -> Result<Vec<Vector3<f64>>, MujocoError> {
        let ran = self.run(&Run {
            integrator,
            steps_per_tick,
            ticks,
            trace: true,
        })?;
        Ok(ran.tcp_m.into_iter().map(Vector3::from).collect())
    }

    /// What that takes of a core, s.
    pub(super) fn core_s(
        &mut self,
        integrator: &str,
        steps_per_tick: usize,
        ticks: usize,
    ) -> Result<f64, MujocoError> {
        let ran = self.run(&Run {
            integrator,
            steps_per_tick,
            ticks,
            trace: false,
        })?;
        Ok(ran.core_s)
    }

    fn run(&mut self, run: &Run<'_>) -> Result<Ran, MujocoError> {
        self.tell(run)?;
        let mut line = String::new();
        self.stdout.read_line(&mut line).map_err(MujocoError::Answer)?;
        serde_json::from_str(&line).map_err(|error| MujocoError::Answer(error.into()))
    }

    fn tell(&mut self, what: &impl Serialize) -> Result<(), MujocoError> {
        let line = serde_json::to_string(what).map_err(|error| MujocoError::Answer(error.into()))?;
        writeln!(self.stdin, "{line}").map_err(MujocoError::Answer)
    }
}

impl Drop for Rival {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What the script makes its model of: the tool `body` that begins as `start` says, and the object of `scenario`.
pub(super) fn model(body: &Body, start: &State, scenario: &Scenario) -> Value {
    let (suspension, object) = (&body.suspension, &scenario.object);
    let pose = body.plate(start).pose;
    let (position, rotation) = (pose.translation.vector, pose.rotation);
    let rad_per_s = TAU * object.swing_frequency_hz;
    let (amplitude, phase) = (object.swing_amplitude_m[2], object.swing_phase_rad);
    json!({
        "tick_s": TICK_S,
        "gravity_m_per_s2": GRAVITY_M_PER_S2,
        "mass_kg": body.mass,
        "inertia_kg_m2": body.inertia.as_slice(),
        "centre_m": body.centre_of_mass.as_slice(),
        "tcp_m": body.tcp.as_slice(),
        "stiffness_n_per_m": suspension.stiffness_n_per_m,
        "damping_ns_per_m": suspension.damping_ns_per_m,
        "stiffness_nm_per_rad": suspension.stiffness_nm_per_rad,
        "damping_nms_per_rad": suspension.damping_nms_per_rad,
        "contact_n_per_m": object.indentation_n_per_m,
        "object_kg": OBJECT_KG,
        "object_n_per_m": OBJECT_KG * rad_per_s * rad_per_s,
        "far_m": FAR_M,
        "slack_m": FAR_M - object.height_m,
        "start_object_m": amplitude * libm::sin(phase),
        "start_object_m_per_s": amplitude * rad_per_s * libm::cos(phase),
        "start_plate_m": position.as_slice(),
        "start_plate_wxyz": [rotation.w, rotation.i, rotation.j, rotation.k],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_not_there_and_who_says_nothing_is_named() {
        let missing = Rival::start(Path::new("/no/such/python"), &json!({}))
            .err()
            .unwrap();
        assert!(
            missing.to_string().starts_with("can't start /no/such/python: "),
            "{missing}"
        );
        // Ends at once.
        let silent = Rival::start(Path::new("true"), &json!({}));
        let silent = silent.and_then(|mut rival| rival.trace("RK4", 1, 1)).unwrap_err();
        assert!(
            silent
                .to_string()
                .starts_with("MuJoCo's process does not answer: "),
            "{silent}"
        );
    }
}
