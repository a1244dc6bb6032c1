//! A run's log, and what is told of it.

use super::*;
use crate::scenarios::Source;
use std::path::Path;

fn log(scenario: &Scenario) -> Log {
    Log::of(Path::new(""), transcript::in_process(scenario).unwrap())
}

#[test]
fn a_simulated_run_tells_all() {
    let scenario = Source::find("paper").unwrap().scenario(&[]).unwrap();
    let mut log = log(&scenario);
    let analysis = Analysis::new(&scenario, &log);
    assert_eq!(
        analysis.metrics().unwrap().unwrap(),
        crate::compare::metrics(&scenario).unwrap()
    );
    assert!(
        analysis
            .channels
            .iter()
            .all(|it| it.missing == 0 && it.senders == 1)
    );
    assert_eq!((analysis.clocks.len(), analysis.timing.answers_s.len()), (0, 0));
    let Impact {
        foreseen: Some(foreseen),
        measured: Some(measured),
        truth: Some([speed, peak, _]),
    } = analysis.impact
    else {
        panic!("{:?}", analysis.impact)
    };
    assert!(
        (foreseen.speed_m_per_s / speed - 1.0).abs() < 0.1,
        "{foreseen:?} {speed} m/s"
    );
    assert!(
        (measured.peak_force_n / peak - 1.0).abs() < 0.25,
        "{measured:?} {peak} N"
    );

    let headline = Headline {
        scenario: "paper <1>",
        log: "a.lcmlog".to_owned(),
        complaints: vec!["it is damaged".to_owned()],
    };
    let page = analysis.html(&scenario, &headline);
    for text in [
        "paper &lt;1&gt;",
        "it is damaged",
        "height in r, mm",
        "deflection in s, um",
        "turned since before, mrad",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains("http://") && !page.contains("https://"));
    let names: Vec<_> = analysis
        .figures(&scenario)
        .iter()
        .map(|figure| figure.name)
        .collect();
    assert_eq!(
        names,
        [
            "force",
            "position",
            "deflection",
            "twist",
            "orientation",
            "impact"
        ]
    );

    // What a recorder on the network hears twice changes nothing; what it does not hear is told.
    let repeated: Vec<_> = log.entries[100..140].to_vec();
    log.entries.splice(140..140, repeated);
    assert_eq!(Analysis::new(&scenario, &log).said, analysis.said);
    log.entries
        .retain(|entry| entry.channel != "ROBOT_STATE" || !(400..410).contains(&(entry.utime / 1000)));
    let text = Analysis::new(&scenario, &log).text(&scenario).to_string();
    assert!(
        text.contains("ROBOT_STATE: 3 messages missing in 1 gaps, after step 396 (3)"),
        "{text}"
    );
}
