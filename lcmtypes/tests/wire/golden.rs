//! The encodings as they have always been. A change here breaks every log and every other program:
//! `UPDATE_GOLDEN=1 cargo test -p lcmtypes` writes the files anew, and PROTOCOL must count up.

use crate::draw::Counting;
use crate::samples::{Sample, for_all_messages};
use lcmtypes::{CHANNELS, Message};
use spatial::ports::*;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

pub(crate) fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Channel, fingerprint, size and the bytes, in groups of eight.
fn listing<M: Message + Sample>() -> String {
    let encoded = M::sample(&mut Counting::default()).encode().unwrap();
    let bytes = encoded.as_bytes();
    let mut text = format!(
        "channel {}\nfingerprint {:#018x}\nbytes {}\n",
        M::CHANNEL,
        M::fingerprint(),
        bytes.len()
    );
    for line in bytes.chunks(32) {
        for group in line.chunks(8) {
            text.push(' ');
            group.iter().for_each(|byte| write!(text, "{byte:02x}").unwrap());
        }
        text.push('\n');
    }
    text
}

fn compare<M: Message + Sample>() {
    let file = directory().join(format!("{}.bytes", M::CHANNEL));
    if env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(&file, listing::<M>()).unwrap();
    }
    let golden = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    assert_eq!(
        listing::<M>(),
        golden,
        "{} has changed; see the head of golden.rs",
        M::CHANNEL
    );
}

#[test]
fn golden_bytes_and_fingerprints() {
    macro_rules! all { ($($message:ty),*) => { $(compare::<$message>();)* } }
    for_all_messages!(all);
}

#[test]
fn no_two_channels_share_a_fingerprint() {
    macro_rules! all { ($($message:ty),*) => { [$((<$message>::fingerprint(), <$message>::CHANNEL)),*] } }
    let fingerprints = for_all_messages!(all);
    assert_eq!(BTreeMap::from(fingerprints).len(), CHANNELS.len());
    assert_eq!(fingerprints.map(|(_, channel)| channel), CHANNELS);
}

#[test]
fn every_packet_is_below_1400_bytes() {
    macro_rules! all { ($($message:ty),*) => { $({
        let encoded = <$message>::sample(&mut Counting::default()).encode().unwrap();
        let packet = 8 + <$message>::CHANNEL.len() + 1 + encoded.as_bytes().len();
        assert!(packet < 1400, "{}: {packet} bytes", <$message>::CHANNEL);
    })* } }
    for_all_messages!(all);
}
