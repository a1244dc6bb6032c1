use super::observer::place;
use super::plant::{ACCELERATION, POSITION, SPEED};
use super::*;
use crate::structure::Modes;
use node::scenario::Scenario;

/// The gantry with the gears that `Scenario::default` assumes, 14 and 20 Hz.
fn design() -> Design {
    Design::new(&Scenario::default()).unwrap()
}

fn structure(gears: Gears) -> Structure {
    let scenario = Scenario::default();
    let axes = scenario.start_axes().unwrap();
    Structure::new(&scenario.controller, &scenario.robot.kinematics(), &axes, gears)
}

/// PLANT.md section 5: the tcp pinned along z, on a robot that does not yield. The pinning spring is a thousand times as
/// stiff as the sensor there, C_tcp,zz = 28.267 um/N.
#[test]
fn the_modes_with_the_tcp_pinned() {
    let found = structure(Gears::Rigid)
        .modes(1e3 / 28.267e-6)
        .as_ref()
        .map(Modes::hz)
        .unwrap();
    for (found, expected) in found.iter().zip([17.52, 31.28, 34.27, 62.56, 73.77]) {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
}

/// At rest the sensor and the gears share the motors' way as their compliances do: PLANT.md section 5 has 28.267 um/N and
/// 2.47 um/N at the tcp. And the contact force is then the sensor's.
#[test]
fn sensor_and_gears_share_the_motors_way() {
    let scenario = Scenario::default();
    let flexibility = Flexibility::new(&scenario.controller, &structure(Gears::Elastic)).unwrap();
    let servo = &scenario.controller.servo;
    let plant = Plant::new(&flexibility, servo, 4, &scenario.controller.elastic).unwrap();
    let expected = -28.267 / (28.267 * 1.001 + 2.47);
    assert!(
        (plant.share() / expected - 1.0).abs() < 1e-3,
        "{} {expected}",
        plant.share()
    );
    let modal: f64 = (0..MODES)
        .map(|i| flexibility.modes[i].force * plant.rest[2 * i])
        .sum();
    let force = modal + flexibility.rigid_force.dot(&flexibility.axes_per_tcp);
    assert!((force / plant.share() - 1.0).abs() < 1e-9, "{force}");
}

/// At rest nothing changes, over a tick and over a period.
#[test]
fn what_rests_stays_at_rest() {
    for plant in &design().plants {
        for transition in [&plant.tick, &plant.period] {
            let moved = (transition * plant.rest - plant.rest).amax();
            assert!(moved < 1e-9 * plant.rest.amax(), "{moved}");
        }
    }
}

/// The regulated plant comes to rest, whatever it does at first; without the regulator it swings on.
#[test]
fn each_hypothesis_is_regulated() {
    for plant in &design().plants {
        let mut state = State::from_fn(|i, _| match i {
            POSITION => 1e-4,
            _ if i % 3 == 0 => 1e-5,
            _ => 0.0,
        });
        let first = state.norm();
        for _ in 0..1000 {
            let change = -(plant.gain * state)[0];
            state = plant.period * state + plant.input * change;
        }
        assert!(state.norm() < 1e-3 * first, "{} {first}", state.norm());
    }
}

/// What the law sees of a plant that is one of its hypotheses, without noise: 20 mm/s downwards until the contact at
/// 0, 4 ms late. Where the deflection is at the end, the object as the law knows it, and the belief in each hypothesis.
fn pressed(real: usize, aim: &Aim) -> (f64, f64, [f64; HYPOTHESES]) {
    const TICKS: usize = 4;
    const DEAD: usize = 2;
    let design = Arc::new(design());
    let plant = design.plants[real];
    let mut law = Elastic::new(Arc::clone(&design));
    // Where the filters are at each tick.
    let mut filters: Vec<Waypoint> = Vec::new();
    let mut state = State::zeros();
    for (i, mode) in (0..MODES).map(|i| (2 * i + 1, plant.rest[2 * i])) {
        state[i] = -0.02 * mode;
    }
    let before = |tick: f64| Waypoint {
        position: -0.02 * tick * TICK_S,
        rate: -0.02,
        change: 0.0,
    };
    for tick in 0..=TICKS * DEAD {
        filters.push(before(tick as f64));
    }
    let mut samples: Vec<ContactSample> = Vec::new();
    for knot in -20..0 {
        law.track(f64::from(knot) * 4e-3, before(f64::from(knot) * 4.0));
    }
    for tick in 0..250 {
        let filter = filters[tick];
        if tick > 0 {
            state = plant.tick * state;
        }
        place(&mut state, &filter, 0.0);
        let yielded: f64 = (0..6)
            .map(|axis| plant.tcp_per_axis[axis] * state[plant::DEVIATION + axis])
            .sum();
        let actual = filter.position + yielded;
        samples.push(ContactSample {
            time_s: tick as f64 * TICK_S,
            object: actual + (plant.seen * state)[0],
            actual,
            ..Default::default()
        });
        if tick % TICKS != 0 {
            continue;
        }
        let acts = tick + TICKS * DEAD;
        law.track(acts as f64 * TICK_S, filters[acts]);
        let late = tick.saturating_sub(2 * TICKS)..tick.saturating_sub(TICKS);
        // The contact is detected after 3 ms.
        for sample in samples[late].iter().filter(|sample| sample.time_s > 2.5e-3) {
            law.take(sample);
        }
        let situation = Situation {
            commanded: 0.0,
            desired: filters[acts].position - 0.02 * 4e-3,
            desired_rate: -0.02,
            actual,
            reached_s: [0.0; PREVIEW],
            period_s: 4e-3,
        };
        law.desired(aim, &situation);
        let next = match law.motion() {
            Some(motion) => motion[0],
            None => before((acts + TICKS) as f64),
        };
        let jerk = (next.change - filters[acts].change) / (4.0 * TICK_S);
        for i in 1..=TICKS {
            let from = filters[acts + i - 1];
            filters.push(Waypoint {
                position: from.position
                    + TICK_S * (from.rate + TICK_S * (from.change / 2.0 + TICK_S * jerk / 6.0)),
                rate: from.rate + TICK_S * (from.change + TICK_S * jerk / 2.0),
                change: from.change + TICK_S * jerk,
            });
        }
    }
    assert!(state[SPEED].abs() < 1e-3 && state[ACCELERATION].abs() < 0.1);
    let belief = weights(law.observers.as_ref().unwrap());
    ((plant.seen * state)[0], law.object().unwrap().0, belief)
}

/// Paper (2): the deflection becomes `C f_d`; the object is found where it is, which the gears do not shift; and the
/// hypothesis that is true is the one that is believed.
#[test]
fn the_law_presses_and_finds_object_and_gears() {
    for real in 0..HYPOTHESES {
        let (deflection, object, belief) = pressed(real, &Aim::PAPER);
        let wanted = Aim::PAPER.displacement;
        assert!(
            (deflection / wanted - 1.0).abs() < 0.02,
            "{real}: {deflection} {wanted}"
        );
        assert!(object.abs() < 3e-6, "{real}: {object} m, {belief:?}");
    }
}
