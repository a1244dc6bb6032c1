use super::super::record::Record;
use super::streams::{sensor, sensor_every};
use super::{all_kept, breaks};
use spatial::ports::{Deflections, Role, SampleFlags};

fn breaks_sensor(rule: &str, words: &str, spoil: impl FnOnce(&mut Record)) {
    breaks(sensor, rule, words, spoil);
}

fn each(record: &mut Record, spoil: impl Fn(&mut Deflections)) {
    record
        .deflections
        .iter_mut()
        .for_each(|it| spoil(&mut it.message));
}

#[test]
fn a_good_sensor_keeps_every_rule_at_any_rate_that_loses_no_reading() {
    for k in 1..=7 {
        all_kept(&sensor_every(k));
    }
}

#[test]
fn pace_and_ticks() {
    let rule = "SENSOR_DEFLECTION every k <= 8 ticks";
    breaks_sensor(rule, "0 heard", |record| record.deflections.clear());
    breaks_sensor(rule, "median 2.00 ms", |record| {
        record
            .deflections
            .iter_mut()
            .enumerate()
            .for_each(|(i, it)| it.us += 1000 * i as i64);
    });
    breaks_sensor(rule, "k = 10 (1 to 8)", |record| *record = sensor_every(10));
    let rule = "step grows with the ticks";
    breaks_sensor(rule, "8 follows 8", |record| {
        record.deflections[9].message.stamp.step = 8
    });
    breaks_sensor(rule, "ms per step", |record| {
        each(record, |it| it.stamp.step *= 4)
    });
    breaks_sensor(rule, "messages missing", |record| {
        record.deflections.retain(|it| it.message.stamp.step % 10 != 0);
    });
}

#[test]
fn readings() {
    let rule = "readings newest first, one tick apart";
    breaks_sensor(rule, "utime is 7000 us after reading 0", |record| {
        each(record, |it| it.samples.reverse())
    });
    breaks_sensor(rule, "readings 1 and 2 are 1500 us apart", |record| {
        record.deflections[50].message.samples[2..]
            .iter_mut()
            .for_each(|it| it.utime -= 500);
    });
    let rule = "a reading stays what it was";
    breaks_sensor(
        rule,
        "reading 3 of step 50 is not reading 2 of step 49",
        |record| {
            record.deflections[50].message.samples[3].deflection.translation.z += 1e-9;
        },
    );
    breaks_sensor(rule, "with another instant", |record| {
        record.deflections.iter_mut().skip(1).step_by(2).for_each(|it| {
            it.message
                .samples
                .iter_mut()
                .for_each(|sample| sample.utime -= 600);
        });
    });
    let rule = "sampling instants advance";
    breaks_sensor(rule, "step 50 was sampled 2000 us before", |record| {
        record.deflections[50].message.stamp.utime -= 3000;
    });
}

#[test]
fn clock() {
    breaks_sensor("utime is not later than sending", "after it was sent", |record| {
        record.deflections[50].message.stamp.utime += 1000;
    });
    breaks_sensor("echo of the newest command", "or none", |record| {
        each(record, |it| it.echo = Default::default())
    });
}

#[test]
fn flags() {
    let rule = "flags say what a reading is";
    breaks_sensor(rule, "0.0 % valid", |record| {
        each(record, |it| {
            it.samples
                .iter_mut()
                .for_each(|sample| sample.flags = SampleFlags::default())
        });
    });
    breaks_sensor(rule, "a force of 3 N without FLAG_WRENCH", |record| {
        record.deflections[50].message.samples[0].wrench.force.z = 3.0;
    });
    breaks_sensor(rule, "a rotation by 4.000 rad", |record| {
        record.deflections[50].message.samples[0].deflection.rotation.x = 4.0;
    });
}

#[test]
fn the_hello_is_that_of_the_robot() {
    breaks_sensor(
        "hello agrees with itself and the peers",
        "but the Robot says",
        |record| {
            let mut robot = record.statuses[0];
            robot.message.role = Role::Robot;
            robot.message.hello.configuration_hash = 5;
            record.peers.push(robot);
        },
    );
}
