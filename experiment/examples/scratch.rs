//! s
use experiment::*;
use node::scenario::Scenario;
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let phases: usize = args[0].parse().unwrap();
    let seeds: usize = args[1].parse().unwrap();
    let overrides = &args[2..];
    let text = std::fs::read_to_string("experiment/scenarios/paper.toml").unwrap();
    let s = Scenario::parse("paper", &text, overrides).unwrap();
    let r = compare::summarise(&compare::variations(&s, phases, seeds));
    match r {
        None => println!("none"),
        Some(r) => println!(
            "peak {:.2} ({:.2}) set10 {:.1} ({:.1}) set2 {:.0} ({:.0}) iae {:.3} ({:.3}) sse {:.3} ({:.3}) ori {:.2} ({:.2}) -> {:.3} ({:.3})",
            r.mean.peak_n,
            r.worst.peak_n,
            r.mean.settling_10_s * 1e3,
            r.worst.settling_10_s * 1e3,
            r.mean.settling_2_s * 1e3,
            r.worst.settling_2_s * 1e3,
            r.mean.iae_n_s,
            r.worst.iae_n_s,
            r.mean.steady_error_n,
            r.worst.steady_error_n,
            r.mean.orientation_max_rad * 1e3,
            r.worst.orientation_max_rad * 1e3,
            r.mean.orientation_end_rad * 1e3,
            r.worst.orientation_end_rad * 1e3
        ),
    }
}
