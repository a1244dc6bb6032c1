//! Each rule with a stream that keeps it and with streams that break it.

mod moved;
mod robot;
mod sensor;
mod signed;
mod streams;

use super::{Expectation, Finding, Record, Table, Verdict};

const EXPECTATION: Expectation = Expectation {
    delay_periods: 2,
    command_gap_s: 0.02,
    moved: true,
};

/// All rules of the record's role.
fn judge(record: &Record) -> Vec<Finding> {
    match record.role {
        spatial::ports::Role::Robot => super::robot(record, &EXPECTATION),
        _ => super::sensor(record),
    }
}

/// Once `spoil` has been at the good stream, `rule` is broken, and says `words`.
fn breaks(good: fn() -> Record, rule: &str, words: &str, spoil: impl FnOnce(&mut Record)) {
    let mut record = good();
    spoil(&mut record);
    let findings = judge(&record);
    let found = findings.iter().find(|it| it.rule == rule).unwrap();
    assert_eq!(found.verdict, Verdict::Broken, "{found:?}");
    assert!(found.observed.contains(words), "{found:?}");
    assert!(found.remedy.is_some());
}

fn all_kept(record: &Record) {
    let findings = judge(record);
    assert!(
        findings.iter().all(|it| it.verdict == Verdict::Kept),
        "{}",
        Table(&findings)
    );
}

#[test]
fn nothing_at_all_is_a_broken_contract() {
    for role in [spatial::ports::Role::Robot, spatial::ports::Role::Sensor] {
        let findings = judge(&Record::new(role));
        let broken = findings.iter().filter(|it| it.verdict == Verdict::Broken);
        assert_eq!(broken.count(), 2, "{}", Table(&findings));
        assert!(
            !findings.iter().any(|it| it.verdict == Verdict::Kept),
            "{}",
            Table(&findings)
        );
    }
}

#[test]
fn a_table_has_a_line_per_rule_and_the_remedies() {
    let findings = [
        Finding::kept("one", "1 of 1"),
        Finding::broken("other", "2 (1)", "halve it"),
    ];
    let text = Table(&findings).to_string();
    assert_eq!(
        text,
        "kept      one    1 of 1\nBROKEN    other  2 (1)\n                 remedy: halve it\n1 rules kept, 1 broken, 0 not seen\n"
    );
}
