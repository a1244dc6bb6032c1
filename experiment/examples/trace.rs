//! s
use experiment::*;
use node::scenario::Scenario;
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let every: i64 = args[0].parse().unwrap();
    let from: i64 = args[1].parse().unwrap();
    let to: i64 = args[2].parse().unwrap();
    let text = std::fs::read_to_string("experiment/scenarios/paper.toml").unwrap();
    let s = Scenario::parse("paper", &text, &args[3..]).unwrap();
    let mut last = None;
    in_process::run(&s, |t| {
        let n = t.link_motion.stamp.step;
        if t.controller.is_some() {
            last = t.controller;
        }
        if n % every == 0 && n >= from && n <= to {
            let c = last.unwrap();
            let tr = &t.sensor.truth;
            println!(
                "{n} {:?} tcpz {:.4} link z {:.4} vz {:.3} sz {:.1}um phiy {:.3} F {:.2} h {:.2}um fest {:.2} cmd {:.4} objz {:.4}",
                c.status.phase,
                tr.tcp_pose.translation.z * 1e3,
                t.link_motion.motion.pose.translation.z * 1e3,
                t.link_motion.motion.velocity.z * 1e3,
                tr.tcp_deflection.translation.z * 1e6,
                tr.tcp_deflection.rotation.y * 1e3,
                tr.contact_force.z,
                tr.indentation_m * 1e6,
                c.status.detection.statistic_n,
                c.command.axis_position[0].z * 1e3,
                c.status.object_pose.translation.z * 1e3
            );
        }
    });
}
