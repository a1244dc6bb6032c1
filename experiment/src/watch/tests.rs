use super::*;
use crate::in_process;
use node::health::Health;
use node::scenario::Scenario;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use spatial::ports::{ControllerStatus, Fault, Hello, NodeState, NodeStatus, Role};
use std::time::{Duration, Instant};

const URL: &str = "udpm://239.255.76.67:7667?ttl=0";

fn start() -> Instant {
    node::clock::now()
}

fn ms(count: u64) -> Duration {
    Duration::from_millis(count)
}

/// The statuses of a controller that presses.
fn pressing() -> Vec<ControllerStatus> {
    let overrides = [
        "task.start_position_m=[0.0, 0.0, 0.0165]",
        "timing.duration_s=0.9",
    ];
    let scenario = Scenario::parse("short", "", &overrides.map(str::to_owned)).unwrap();
    let mut statuses = Vec::new();
    in_process::run(&scenario, |tick| {
        statuses.extend(tick.controller.as_ref().map(|outputs| outputs.status));
    });
    statuses
}

fn node(role: Role) -> NodeStatus {
    let mut status = Health::new(role, Hello::default()).status();
    status.host = [0; 32];
    status.host[..4].copy_from_slice(b"here");
    status.state = NodeState::Running;
    status.stamp.boot_id = 7;
    status
}

/// A view that has heard all of a short contact, the last at the instant.
fn contact(now: Instant) -> View {
    let mut view = View::default();
    for role in [Role::Robot, Role::Sensor, Role::Controller] {
        view.hear(&Heard::Node(node(role)), now);
    }
    for status in pressing() {
        view.hear(&Heard::Controller(status), now);
    }
    view
}

fn drawn(view: &View, now: Instant, [width, height]: [u16; 2]) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    let snapshot = view.snapshot(now);
    terminal
        .draw(|frame| screen::draw(frame, URL, &snapshot, view.points()))
        .unwrap();
    let buffer = terminal.backend().buffer();
    let line = |y| {
        (0..width)
            .map(move |x| buffer[(x, y)].symbol())
            .collect::<String>()
    };
    (0..height)
        .map(|y| line(y).trim_end().to_owned() + "\n")
        .collect()
}

#[test]
fn a_contact_is_shown_with_its_force_and_its_plot() {
    let now = start();
    let text = drawn(&contact(now), now, [80, 30]);
    assert!(text.contains("settled, law proposed"), "{text}");
    assert!(text.contains(" N of 10.00 N (error "), "{text}");
    assert!(text.contains("contact at 0."), "{text}");
    assert!(text.contains("controller here"), "{text}");
    // Braille.
    let dots = text
        .chars()
        .filter(|symbol| ('\u{2801}'..='\u{28ff}').contains(symbol))
        .count();
    assert!(dots > 20, "{text}");
}

#[test]
fn no_size_and_no_silence_is_too_little_to_draw() {
    let now = start();
    let (view, empty) = (contact(now), View::default());
    for size in [[1, 1], [10, 3], [40, 10], [80, 24], [200, 60]] {
        drawn(&view, now, size);
        drawn(&empty, now, size);
    }
    let text = drawn(&empty, now, [80, 24]);
    assert_eq!(text.matches("not heard").count(), 3, "{text}");
    assert!(text.contains("no controller is heard"), "{text}");
}

#[test]
fn faults_and_silence_are_words_not_colours_alone() {
    let now = start();
    let mut view = contact(now);
    let mut robot = node(Role::Robot);
    (robot.state, robot.fault) = (NodeState::Fault, Fault::CommandGap);
    view.hear(&Heard::Node(robot), now);
    let text = drawn(&view, now + ms(2500), [100, 30]);
    assert!(text.contains("fault: command gap"), "{text}");
    assert!(text.contains("silent"), "{text}");
    assert!(text.contains("2.5 s"), "{text}");
}

#[test]
fn rate_and_loss_are_those_heard_here() {
    let now = start();
    let mut view = View::default();
    view.hear(&Heard::Node(node(Role::Controller)), now);
    let mut status = pressing()[0];
    status.stamp.boot_id = 7;
    for cycle in 0..600_u32 {
        status.stamp.step = i64::from(4 * cycle);
        // Every fifth is lost, and one is heard twice.
        if cycle % 5 != 4 {
            let at = now + ms(4) * cycle;
            view.hear(&Heard::Controller(status), at);
            view.hear(&Heard::Controller(status), at);
        }
    }
    let end = now + ms(4) * 599;
    let row = view
        .snapshot(end)
        .nodes
        .into_iter()
        .find(|row| row.node == "controller")
        .unwrap();
    assert!((row.rate_hz - 200.0).abs() < 2.0, "{} Hz", row.rate_hz);
    assert!((row.loss_ratio - 0.2).abs() < 0.01, "{}", row.loss_ratio);
    assert!(!row.silent);
    // A step from nowhere does not make it deaf.
    status.stamp.step = 8_000_000_000_000;
    view.hear(&Heard::Controller(status), end);
    for cycle in 600..1200_u32 {
        status.stamp.step = i64::from(4 * cycle);
        view.hear(&Heard::Controller(status), now + ms(4) * cycle);
    }
    let row = view
        .snapshot(now + ms(4) * 1199)
        .nodes
        .into_iter()
        .find(|row| row.node == "controller")
        .unwrap();
    assert!((row.rate_hz - 250.0).abs() < 3.0, "{} Hz", row.rate_hz);
    let silent = view
        .snapshot(now + ms(10_000))
        .nodes
        .into_iter()
        .find(|row| row.node == "controller")
        .unwrap();
    assert_eq!((silent.rate_hz, silent.silent), (0.0, true));
}

#[test]
fn processes_are_told_apart_and_forgotten() {
    let now = start();
    let mut view = View::default();
    for boot_id in 0..100 {
        let mut status = node(Role::Controller);
        status.stamp.boot_id = boot_id;
        view.hear(&Heard::Node(status), now);
    }
    let controllers = |view: &View, now| {
        view.snapshot(now)
            .nodes
            .iter()
            .filter(|row| row.node == "controller")
            .count()
    };
    assert_eq!(controllers(&view, now), 8);
    let mut status = node(Role::Controller);
    status.stamp.boot_id = 1000;
    view.hear(&Heard::Node(status), now + ms(20_000));
    assert_eq!(controllers(&view, now + ms(20_000)), 1);
}

#[test]
fn plots_keep_their_window_and_begin_anew() {
    let now = start();
    let mut view = View::default();
    let mut status = pressing()[0];
    for step in 0..20_000 {
        status.stamp.step = step;
        view.hear(&Heard::Controller(status), now);
    }
    let kept = view.points().iter().count();
    assert_eq!(kept as f64 * 1e-3, WINDOW_S + 1e-3);
    let next = view.points().next();
    assert_eq!(view.points().since(next - 3).count(), 3);
    assert_eq!(view.points().since(0).count(), kept);
    status.stamp.boot_id += 1;
    view.hear(&Heard::Controller(status), now);
    assert_eq!(view.points().iter().count(), 1);
    assert!(view.points().first() > next);
}

#[test]
fn lines_tell_changes_at_once_and_numbers_every_second() {
    let now = start();
    let mut view = View::default();
    let mut lines = Lines::default();
    assert!(lines.tell(&view.snapshot(now), now).is_empty());
    let now = now + ms(1000);
    assert_eq!(lines.tell(&view.snapshot(now), now).len(), 3);
    assert!(lines.tell(&view.snapshot(now), now).is_empty());
    view.hear(&Heard::Node(node(Role::Sensor)), now);
    assert_eq!(
        lines.tell(&view.snapshot(now), now),
        ["sensor-sim  here          running"]
    );
    let statuses = pressing();
    let mut told = Vec::new();
    for (i, status) in statuses.iter().enumerate() {
        let at = now + ms(4 * i as u64);
        view.hear(&Heard::Controller(*status), at);
        view.hear(&Heard::Node(node(Role::Sensor)), at);
        told.extend(lines.tell(&view.snapshot(at), at));
    }
    let phases: Vec<_> = told
        .iter()
        .map(|line| line.split_ascii_whitespace().nth(2).unwrap())
        .collect();
    assert!(
        phases.starts_with(&["sync", "ready", "approach", "contact"]) && phases.ends_with(&["settled"]),
        "{told:#?}"
    );
    let last = told.last().unwrap();
    let words: Vec<_> = last.split_ascii_whitespace().collect();
    let force_n: f64 = words[words.iter().position(|word| *word == "force").unwrap() + 1]
        .parse()
        .unwrap();
    assert!((force_n - 10.0).abs() < 1.0, "{last}");
    assert!(told[0].contains("force 0.00 N of 10.00 N  tcp "), "{}", told[0]);
    // Silence is a change, too; the last numbers are told once.
    let late = now + ms(10_000);
    let [silent, numbers] = &lines.tell(&view.snapshot(late), late)[..] else {
        panic!("two lines");
    };
    assert_eq!(silent, "sensor-sim  here          silent");
    assert!(numbers.contains("settled"), "{numbers}");
    assert!(
        lines
            .tell(&view.snapshot(late + ms(5000)), late + ms(5000))
            .is_empty()
    );
}
