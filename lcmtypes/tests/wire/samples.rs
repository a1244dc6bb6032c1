//! A value of every message, member by member.

use crate::draw::Draw;
use spatial::ports::*;
use spatial::{Compliance, Deflection, Motion, Wrench};

/// A message that can be drawn.
pub(crate) trait Sample {
    fn sample(draw: &mut impl Draw) -> Self;
}

fn stamp(draw: &mut impl Draw) -> Stamp {
    Stamp {
        step: draw.step(),
        utime: draw.utime(),
        boot_id: draw.integer(),
    }
}

fn echo(draw: &mut impl Draw) -> ClockEcho {
    ClockEcho {
        command_send_utime: draw.integer(),
        receive_utime: draw.integer(),
        send_utime: draw.integer(),
    }
}

fn authenticity(draw: &mut impl Draw) -> Authenticity {
    Authenticity {
        session: draw.integer(),
        seq: draw.integer(),
        key_id: draw.int(),
        tag: [(); 16].map(|()| draw.integer() as u8),
    }
}

fn deflection(draw: &mut impl Draw) -> Deflection {
    Deflection {
        translation: draw.vector(),
        rotation: draw.vector(),
    }
}

fn wrench(draw: &mut impl Draw) -> Wrench {
    Wrench {
        force: draw.vector(),
        moment: draw.vector(),
    }
}

fn motion(draw: &mut impl Draw) -> Motion {
    Motion {
        pose: draw.pose(),
        velocity: draw.vector(),
        angular_velocity: draw.vector(),
        acceleration: draw.vector(),
        angular_acceleration: draw.vector(),
    }
}

impl Sample for RobotState {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            sample_count: draw.count(8) as i32 + 1,
            axis_position: [(); 8].map(|()| draw.axes()),
            axis_velocity: draw.axes(),
            axis_setpoint: draw.axes(),
            mode: draw.one_of(RobotMode::ALL),
            fault: draw.one_of(Fault::ALL),
            fault_axis: draw.count(7) as i32 - 1,
            command_step: draw.integer(),
            missed_commands: draw.integer(),
            echo: echo(draw),
            authenticity: authenticity(draw),
        }
    }
}

impl Sample for Deflections {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            samples: [(); 8].map(|()| DeflectionSample {
                utime: draw.utime(),
                deflection: deflection(draw),
                wrench: wrench(draw),
                flags: SampleFlags::from_bits(draw.int()),
            }),
            echo: echo(draw),
            authenticity: authenticity(draw),
        }
    }
}

impl Sample for Command {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            enable: draw.bool(),
            axis_position: [(); 8].map(|()| draw.axes()),
            send_utime: draw.integer(),
            authenticity: authenticity(draw),
        }
    }
}

impl Sample for ControllerStatus {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            phase: draw.one_of(ControllerPhase::ALL),
            fault: draw.one_of(Fault::ALL),
            law: draw.one_of(Law::ALL),
            object_known: draw.bool(),
            object_pose: draw.pose(),
            object_velocity: draw.vector(),
            tcp_pose: draw.pose(),
            wrench: wrench(draw),
            desired_wrench: wrench(draw),
            force_error_n: draw.real(),
            detection: Detection {
                statistic_n: draw.real(),
                threshold_n: draw.real(),
                contact_step: draw.integer(),
            },
            compliance: Compliance {
                translation: draw.matrix(),
                rotation: draw.matrix(),
            },
            compliance_confidence: draw.real(),
            tare: deflection(draw),
            impact: ImpactAssessment {
                speed_m_per_s: draw.real(),
                effective_mass_kg: draw.real(),
                peak_force_n: draw.real(),
                maximum_depth_m: draw.real(),
                characteristic_time_s: draw.real(),
                speed_limit_m_per_s: draw.real(),
            },
            gain_margin: draw.real(),
            phase_margin_rad: draw.real(),
            oscillation_n: draw.real(),
            limits: draw.int(),
            program_step: draw.int(),
            task_step: draw.integer(),
            task_answer: draw.one_of(ParameterAnswer::ALL),
            task_parameter: draw.count(TaskParameters::COUNT + 1) as i32 - 1,
            task_limit: draw.real(),
        }
    }
}

impl Sample for NodeStatus {
    fn sample(draw: &mut impl Draw) -> Self {
        let latencies = |draw: &mut _| {
            let [p50_s, p99_s, p999_s, max_s] = [(); 4].map(|()| Draw::real(draw));
            Latencies {
                p50_s,
                p99_s,
                p999_s,
                max_s,
            }
        };
        Self {
            stamp: stamp(draw),
            role: draw.one_of(Role::ALL),
            host: [(); 32].map(|()| draw.integer() as u8),
            state: draw.one_of(NodeState::ALL),
            fault: draw.one_of(Fault::ALL),
            fault_step: draw.integer(),
            fault_peer: draw.one_of(Role::ALL),
            fault_expected: draw.integer(),
            fault_found: draw.integer(),
            hello: Hello {
                run_id: draw.integer(),
                protocol: draw.int(),
                ticks_per_cycle: draw.int(),
                seed: draw.integer(),
                configuration_hash: draw.integer(),
            },
            link: LinkQuality {
                published: draw.integer(),
                received: draw.integer(),
                repeated: draw.integer(),
                lost: draw.integer(),
                dropped: draw.integer(),
                kernel_dropped: draw.integer(),
                undecodable: draw.integer(),
                refused: draw.integer(),
                missed: draw.integer(),
            },
            answer: latencies(draw),
            lateness: latencies(draw),
            round_trip: latencies(draw),
            age: latencies(draw),
            clock_offset_s: [draw.real(), draw.real()],
            clock_bound_s: [draw.real(), draw.real()],
            clock_rate: [draw.real(), draw.real()],
            slip_s: draw.real(),
            authenticated: draw.bool(),
            realtime: draw.bool(),
        }
    }
}

impl Sample for Task {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            action: draw.one_of(TaskAction::ALL),
            parameters: TaskParameters::from_values(
                [(); TaskParameters::COUNT].map(|()| draw.given().then(|| draw.real())),
            ),
            authenticity: authenticity(draw),
        }
    }
}

impl Sample for ObjectPose {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            visible: draw.bool(),
            pose: draw.pose(),
            velocity: draw.vector(),
            angular_velocity: draw.vector(),
            position_sigma_m: draw.real().abs(),
        }
    }
}

impl Sample for LinkMotion {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            motion: motion(draw),
            kinetic_energy_j: draw.real(),
            elastic_energy_j: draw.real(),
            motor_work_j: draw.real(),
            dissipated_energy_j: draw.real(),
        }
    }
}

impl Sample for ToolMotion {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            motion: motion(draw),
        }
    }
}

impl Sample for Truth {
    fn sample(draw: &mut impl Draw) -> Self {
        Self {
            stamp: stamp(draw),
            tcp_pose: draw.pose(),
            tcp_velocity: draw.vector(),
            tcp_deflection: deflection(draw),
            contact_force: draw.vector(),
            contact_force_peak_n: draw.real(),
            indentation_m: draw.real(),
            remaining_indentation_m: draw.real(),
            object_height_m: draw.real(),
            first_contact_speed_m_per_s: draw.real(),
            first_contact_time_s: draw.real(),
            kinetic_energy_j: draw.real(),
            gravity_energy_j: draw.real(),
            elastic_energy_j: draw.real(),
            link_work_j: draw.real(),
            dissipated_energy_j: draw.real(),
            contact_work_j: draw.real(),
        }
    }
}

/// Calls a macro with all message types.
macro_rules! for_all_messages {
    ($($call:tt)*) => {
        $($call)*!(
            RobotState, Deflections, Command, ControllerStatus, NodeStatus, Task, ObjectPose, LinkMotion, ToolMotion,
            Truth
        )
    };
}
pub(crate) use for_all_messages;
