use super::super::record::{Record, Saying};
use super::streams::{robot, signing_robot};
use super::{all_kept, breaks};
use spatial::ports::RobotMode;

#[test]
fn a_robot_with_the_key_keeps_every_rule() {
    all_kept(&signing_robot());
}

#[test]
fn the_key_and_its_tags() {
    let rule = "signed with the key, or without a key";
    let signed = |spoil: fn(&mut Record)| move |record: &mut Record| spoil(record);
    breaks(robot, rule, "node_authenticated is 0, here it is 1", |record| {
        record.signed = Some(Default::default());
    });
    breaks(
        signing_robot,
        rule,
        "node_authenticated is 1, here it is 0",
        |record| {
            record.signed = None;
        },
    );
    let none = signed(|record| {
        let signed = record.signed.as_mut().unwrap();
        (signed.refused, signed.taken) = (signed.taken, 0);
        signed.why = Some("its tag is wrong".to_owned());
    });
    breaks(
        signing_robot,
        rule,
        "0 of 1525 ROBOT_STATE are signed and new (95 %); the first other: its tag is wrong",
        none,
    );
    let tenth = signed(|record| {
        let signed = record.signed.as_mut().unwrap();
        signed.refused = signed.taken / 10;
    });
    breaks(signing_robot, rule, "(95 %)", tenth);
}

#[test]
fn what_is_not_signed_does_nothing() {
    let rule = "an enabled command that is not signed does nothing";
    breaks(signing_robot, rule, "modes Armed", |record| {
        let phase = record.phase(Saying::Unsigned).unwrap();
        for it in &mut record.states {
            if (phase.from_us..phase.until_us).contains(&it.us) {
                it.message.mode = RobotMode::Armed;
            }
        }
    });
}
