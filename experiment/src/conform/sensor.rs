//! Rules for a sensor.

use super::Finding;
use super::record::{At, Record, pairs, quantile};
use spatial::TICK_US;
use spatial::ports::{DEFLECTION_SAMPLES, Deflections};

/// Messages may come every so many ticks, so that no reading is missing.
const MOST_TICKS: i64 = DEFLECTION_SAMPLES as i64;
/// Of so many messages one may be lost on the way.
const LOSS: f64 = 0.05;
/// The median distance of messages may be off by so much.
const PACE: f64 = 0.1;
/// Neighbouring readings may be off from a tick by so much, us.
const APART_US: i64 = 100;
/// What two messages say of when the same reading was taken may differ by so much, us, ...
const RESTATED_US: i64 = 500;
/// ... but for so many of them: a simulated world slips where the machine is busy.
const RESTATED: f64 = 0.05;

/// All of them.
pub fn rules(record: &Record) -> Vec<Finding> {
    vec![
        period(record),
        step(record),
        newest_first(record),
        same_readings(record),
        monotonic(record),
        flags(record),
        noise(record),
    ]
}

/// Every how many ticks messages come, by what they say; 0: less than two came.
pub fn every_ticks(record: &Record) -> i64 {
    let steps = pairs(&record.deflections).map(|(a, b)| (b.message.stamp.step - a.message.stamp.step) as f64);
    quantile(&steps.collect::<Vec<_>>(), 0.5).map_or(0, |ticks| ticks as i64)
}

/// `SENSOR_DEFLECTION` every tick, or every k ticks.
pub fn period(record: &Record) -> Finding {
    const RULE: &str = "SENSOR_DEFLECTION every k <= 8 ticks";
    if record.deflections.len() < 2 {
        let observed = format!(
            "{} heard in {:.1} s",
            record.deflections.len(),
            1e-6 * record.listened_us as f64
        );
        let remedy = "publish SENSOR_DEFLECTION every tick, or every k <= 8 ticks, on the same LCM URL; a simulated sensor needs its \
                      robot to go on (start robot-sim)";
        return Finding::broken(RULE, observed, remedy);
    }
    let gaps: Vec<f64> = pairs(&record.deflections)
        .map(|(a, b)| 1e-3 * (b.us - a.us) as f64)
        .collect();
    let [median, p99, longest] = [0.5, 0.99, 1.0].map(|ratio| quantile(&gaps, ratio).unwrap_or(0.0));
    let k = every_ticks(record);
    let kept = (1..=MOST_TICKS).contains(&k) && (median - k as f64).abs() <= PACE * k as f64;
    let observed = format!(
        "k = {k} (1 to {MOST_TICKS}) by step; median {median:.2} ms (k within {:.0} %), 99th percentile {p99:.2}, longest {longest:.2}",
        100.0 * PACE
    );
    let remedy = "publish every tick of 1 ms, or every k <= 8 ticks, by absolute deadlines: a message carries eight readings";
    Finding::judge(RULE, kept, observed, remedy)
}

/// `step` counts ticks of 1 ms, from whatever start.
pub fn step(record: &Record) -> Finding {
    const RULE: &str = "step grows with the ticks";
    let k = every_ticks(record);
    if record.deflections.len() < 2 {
        return Finding::not_seen(RULE, "fewer than two messages");
    }
    let remedy = "count ticks of 1 ms from the start, also those in which no message is sent";
    let steps = || pairs(&record.deflections).map(|(a, b)| [a.message.stamp.step, b.message.stamp.step]);
    if let Some([a, b]) = steps().find(|[a, b]| b <= a) {
        return Finding::broken(RULE, format!("{b} follows {a}"), remedy);
    }
    let (Some(first), Some(last)) = (record.deflections.first(), record.deflections.last()) else {
        return Finding::not_seen(RULE, "no message");
    };
    let ticks = last.message.stamp.step - first.message.stamp.step;
    let per_tick = (last.us - first.us) as f64 / ticks as f64;
    if per_tick > 2.0 * TICK_US as f64 || per_tick < 0.5 * TICK_US as f64 {
        return Finding::broken(RULE, format!("{:.2} ms per step (1)", 1e-3 * per_tick), remedy);
    }
    let lost: i64 = steps()
        .map(|[a, b]| (b - a) / k.max(1) - 1)
        .filter(|lost| *lost > 0)
        .sum();
    let sent = record.deflections.len() as i64 + lost;
    let observed = format!(
        "{lost} of {sent} messages missing (at most {:.0} %)",
        100.0 * LOSS
    );
    Finding::judge(RULE, lost as f64 <= LOSS * sent as f64, observed, remedy)
}

/// Readings stand newest first, one tick apart, and `utime` is that of the first.
pub fn newest_first(record: &Record) -> Finding {
    const RULE: &str = "readings newest first, one tick apart";
    let remedy = "deflection_sample_us[0] is utime, and each further reading was taken 1000 us earlier";
    if record.deflections.is_empty() {
        return Finding::not_seen(RULE, "no message");
    }
    let mut worst = 0;
    for At { message, .. } in &record.deflections {
        let step = message.stamp.step;
        if message.stamp.utime != message.samples[0].utime {
            let ahead = message.stamp.utime - message.samples[0].utime;
            return Finding::broken(
                RULE,
                format!("step {step}: utime is {ahead} us after reading 0"),
                remedy,
            );
        }
        for (i, (newer, older)) in pairs(&message.samples).enumerate() {
            let apart = newer.utime - older.utime;
            if !(newer.flags.valid && older.flags.valid) {
                continue;
            }
            worst = worst.max((apart - TICK_US).abs());
            if (apart - TICK_US).abs() > APART_US {
                let observed = format!(
                    "step {step}: readings {i} and {} are {apart} us apart (1000 within {APART_US})",
                    i + 1
                );
                return Finding::broken(RULE, observed, remedy);
            }
        }
    }
    Finding::kept(RULE, format!("within {worst} us ({APART_US})"))
}

/// What two messages both have is the same.
pub fn same_readings(record: &Record) -> Finding {
    const RULE: &str = "a reading stays what it was";
    let remedy = "keep the last eight readings as they were taken, with their instants, and move them by the ticks between messages";
    let [mut compared, mut restated] = [0_usize; 2];
    for (a, b) in pairs(&record.deflections) {
        let ticks = b.message.stamp.step - a.message.stamp.step;
        let Some(shift) = usize::try_from(ticks).ok().filter(|shift| *shift > 0) else {
            continue;
        };
        for (i, (newer, older)) in b
            .message
            .samples
            .iter()
            .skip(shift)
            .zip(&a.message.samples)
            .enumerate()
        {
            compared += 1;
            let same = newer.deflection == older.deflection
                && newer.wrench == older.wrench
                && newer.flags == older.flags;
            if !same {
                let observed = format!(
                    "reading {} of step {} is not reading {i} of step {}",
                    i + shift,
                    b.message.stamp.step,
                    a.message.stamp.step
                );
                return Finding::broken(RULE, observed, remedy);
            }
            restated += usize::from(older.flags.valid && (newer.utime - older.utime).abs() > RESTATED_US);
        }
    }
    if compared == 0 {
        return Finding::not_seen(RULE, "no two messages overlap");
    }
    let observed = format!(
        "{compared} readings that two messages share are the same, {restated} with another instant (at most {:.0} %)",
        100.0 * RESTATED
    );
    Finding::judge(
        RULE,
        restated as f64 <= RESTATED * compared as f64,
        observed,
        remedy,
    )
}

/// Sampling instants advance.
pub fn monotonic(record: &Record) -> Finding {
    const RULE: &str = "sampling instants advance";
    if record.deflections.len() < 2 {
        return Finding::not_seen(RULE, "fewer than two messages");
    }
    let utime = |it: &At<Deflections>| it.message.stamp.utime;
    if let Some((a, b)) = pairs(&record.deflections).find(|(a, b)| utime(b) <= utime(a)) {
        let back = utime(a) - utime(b);
        let observed = format!(
            "step {} was sampled {back} us before the message before it",
            b.message.stamp.step
        );
        return Finding::broken(
            RULE,
            observed,
            "read a monotonic clock when sampling; send no reading as the newest twice",
        );
    }
    Finding::kept(RULE, format!("{} messages", record.deflections.len()))
}

/// Flags tell what is known: readings are valid, wrenches are there where they are measured.
pub fn flags(record: &Record) -> Finding {
    const RULE: &str = "flags say what a reading is";
    let newest = || record.deflections.iter().map(|it| &it.message.samples[0]);
    let all = || {
        record
            .deflections
            .iter()
            .flat_map(|it| it.message.samples.iter().map(move |sample| (it, sample)))
    };
    if let Some((it, sample)) = all().find(|(_, sample)| {
        !sample.flags.wrench_measured
            && (sample.wrench.force.amax() > 0.0 || sample.wrench.moment.amax() > 0.0)
    }) {
        let observed = format!(
            "step {} has a force of {} N without FLAG_WRENCH",
            it.message.stamp.step,
            sample.wrench.force.norm()
        );
        return Finding::broken(
            RULE,
            observed,
            "flag a wrench that is measured, and send zeros where none is",
        );
    }
    let turn = all()
        .map(|(_, sample)| sample.deflection.rotation.norm())
        .fold(0.0, f64::max);
    if turn > std::f64::consts::PI {
        return Finding::broken(
            RULE,
            format!("a rotation by {turn:.3} rad"),
            "deflection_rotation_rad is axis times angle in rad, up to pi; not degrees",
        );
    }
    let count = newest().count();
    if count == 0 {
        return Finding::not_seen(RULE, "no message");
    }
    let share = |what: fn(&spatial::ports::SampleFlags) -> bool| {
        100.0 * newest().filter(|sample| what(&sample.flags)).count() as f64 / count as f64
    };
    let [valid, saturated, wrench] = [
        share(|it| it.valid),
        share(|it| it.saturated),
        share(|it| it.wrench_measured),
    ];
    let observed =
        format!("{valid:.1} % valid (above 0), {saturated:.1} % saturated, {wrench:.1} % with a wrench");
    Finding::judge(
        RULE,
        valid > 0.0,
        observed,
        "set FLAG_VALID on readings that were taken",
    )
}

/// What the readings scatter by; no rule can say how much is right.
pub fn noise(record: &Record) -> Finding {
    const RULE: &str = "readings scatter by (told only)";
    let valid = || {
        record
            .deflections
            .iter()
            .map(|it| &it.message.samples[0])
            .filter(|sample| sample.flags.valid)
    };
    let count = valid().count() as f64;
    if count < 2.0 {
        return Finding::not_seen(RULE, "fewer than two valid readings");
    }
    let sigma = |value: &dyn Fn(&spatial::ports::DeflectionSample) -> f64| {
        let mean = valid().map(value).sum::<f64>() / count;
        (valid()
            .map(|it| (value(it) - mean) * (value(it) - mean))
            .sum::<f64>()
            / (count - 1.0))
            .sqrt()
    };
    let translation = (0..3)
        .map(|i| sigma(&|it| it.deflection.translation[i]))
        .fold(0.0, f64::max);
    let rotation = (0..3)
        .map(|i| sigma(&|it| it.deflection.rotation[i]))
        .fold(0.0, f64::max);
    let observed = format!(
        "up to {:.3} um and {:.3} urad (standard deviation of an axis)",
        1e6 * translation,
        1e6 * rotation
    );
    Finding::kept(RULE, observed)
}
