//! The section `[network]`, and which messages it loses.

use super::{Scenario, schema};

schema::section! {
    /// What the network between the devices does to their messages. The simulated world (`SIM_*`) is not impaired.
    Network at "network" {
        /// Share of the messages of every device channel that is lost for good, each by chance: in the loop in one process.
        /// In lockstep over LCM what is lost is repeated.
        loss_ratio: f64 = 0.0, in 0.0..=0.9;
    }
}

impl Scenario {
    /// Whether the message of `step` on `channel` is lost. By chance, but whoever asks gets the same answer: chance is a
    /// hash of seed, channel and step, not a stream that somebody draws from.
    pub fn loses(&self, channel: &str, step: i64) -> bool {
        let ratio = self.network.loss_ratio;
        if ratio == 0.0 {
            return false;
        }
        let of_channel = channel
            .bytes()
            .fold(self.timing.seed as u64, |hash, byte| mix(hash ^ u64::from(byte)));
        let chance = mix(of_channel ^ mix(step as u64)) >> 11;
        (chance as f64) < ratio * (1u64 << 53) as f64
    }
}

/// One step of the generator SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): neighbours become unrelated.
fn mix(state: u64) -> u64 {
    let z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lost(ratio: f64, seed: i64, channel: &str) -> Vec<bool> {
        let mut scenario = Scenario::default();
        scenario.network.loss_ratio = ratio;
        scenario.timing.seed = seed;
        (0..20_000).map(|step| scenario.loses(channel, step)).collect()
    }

    fn share(of: impl Iterator<Item = bool>) -> f64 {
        of.filter(|lost| *lost).count() as f64 / 20_000.0
    }

    #[test]
    fn as_many_as_are_asked_for_and_none_without() {
        assert_eq!(share(lost(0.0, 1, "ROBOT_STATE").into_iter()), 0.0);
        for ratio in [0.05, 0.2, 0.9] {
            let found = share(lost(ratio, 1, "ROBOT_STATE").into_iter());
            assert!((found - ratio).abs() < 0.01, "{found} instead of {ratio}");
        }
    }

    /// Steps, channels and seeds have nothing to do with each other: what both of two lose is the square of what each
    /// loses.
    #[test]
    fn losses_are_independent() {
        let one = lost(0.2, 1, "ROBOT_STATE");
        let mut next = one.clone();
        next.rotate_left(1);
        for other in [next, lost(0.2, 1, "ROBOT_COMMAND"), lost(0.2, 2, "ROBOT_STATE")] {
            let both = share(one.iter().zip(other).map(|(a, b)| *a && b));
            assert!((both - 0.04).abs() < 0.005, "{both}");
        }
    }
}
