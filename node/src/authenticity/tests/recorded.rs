//! A session as somebody on the network records it, changed and played again.

use super::super::*;
use super::cell::{Cell, Said, keyring, secret};
use hmac::{Hmac, KeyInit, Mac};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use sha2::Sha256;

/// Periods, the robot being armed in their middle.
const PERIODS: usize = 30;
const ARMED: usize = 15;

/// What is said in them, all of it taken; `before` sees the cell and what comes next.
fn record(cell: &mut Cell, mut before: impl FnMut(&Cell, &Said)) -> Vec<Said> {
    assert!(cell.settle(3) <= 4);
    let mut said = Vec::new();
    for period in 0..PERIODS {
        if period == ARMED {
            // The others follow within a period or two, and nothing is lost meanwhile.
            cell.robot.renew();
        }
        let now = cell.say(3);
        before(cell, &now);
        assert_eq!(cell.hear(&now), [Ok(()); 7], "period {period}");
        said.push(now);
    }
    said
}

/// Change each bit of `message` in turn, of which `gate` takes none, but then `message` itself.
fn flip<M: Signed>(gate: &Gate, message: &M) {
    let mut gate = gate.clone();
    let mut bytes = message.encode().unwrap().as_bytes().to_vec();
    for bit in 0..8 * bytes.len() {
        bytes[bit / 8] ^= 1 << (bit % 8);
        // What can be decoded is another message, or the same one said otherwise.
        if let Ok(altered) = M::decode(&bytes) {
            assert_eq!(altered.encode().unwrap().as_bytes(), bytes);
            let refused = gate.admit(&altered);
            assert!(
                matches!(refused, Err(Refusal::Tag | Refusal::Key { .. })),
                "{} bit {bit}: {refused:?}",
                M::CHANNEL
            );
        }
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    for length in 0..bytes.len() {
        assert!(M::decode(&bytes[..length]).is_err());
    }
    assert_eq!(gate.admit(message), Ok(()));
}

#[test]
fn no_bit_can_be_changed() {
    record(&mut Cell::new(), |cell, said| {
        flip(&cell.controller, &said.state);
        flip(&cell.robot, &said.command);
        flip(&cell.controller, &said.deflections);
        flip(&cell.robot, &said.task);
    });
}

/// Everybody hears `said` again, in that order.
fn nothing_is_taken<'a>(cell: &mut Cell, said: impl IntoIterator<Item = &'a Said>) {
    for old in said {
        let heard = cell.hear(old);
        assert!(
            heard.iter().all(Result::is_err),
            "{}: {heard:?}",
            old.state.stamp.step
        );
    }
}

#[test]
fn nothing_is_taken_twice() {
    let mut cell = Cell::new();
    let said = record(&mut cell, |_, _| ());
    nothing_is_taken(&mut cell, &said);
    let mut shuffled: Vec<&Said> = said.iter().collect();
    let mut random = Pcg64::seed_from_u64(12);
    for left in (1..shuffled.len()).rev() {
        shuffled.swap(left, random.next_u64() as usize % (left + 1));
    }
    nothing_is_taken(&mut cell, shuffled.iter().copied());
    // Played while the cell goes on, which that does not disturb.
    for old in &said {
        let now = cell.say(3);
        assert_eq!(cell.hear(&now), [Ok(()); 7]);
        nothing_is_taken(&mut cell, [old]);
    }
}

#[test]
fn nothing_is_taken_in_a_later_session() {
    let mut cell = Cell::new();
    let said = record(&mut cell, |_, _| ());
    for _ in 0..2 {
        cell.robot.renew();
        cell.settle(3);
    }
    nothing_is_taken(&mut cell, &said);
    // Of other processes, on which no number is known; who has heard none of the robot's states learns from an old one.
    let mut later = Cell::new();
    later.robot = Gate::of_robot(keyring(secret()), &[9; KEY_BYTES]);
    later.settle(33);
    for old in &said {
        let Said {
            command,
            deflections,
            task,
            ..
        } = old;
        assert!(later.robot.admit(command).is_err() && later.robot.admit(deflections).is_err());
        assert!(later.robot.admit(task).is_err());
        assert!(later.controller.admit(deflections).is_err() && later.controller.admit(task).is_err());
    }
}

/// The contract once more, by itself: who signs with another's key, or for another channel, is nobody.
#[test]
fn another_author_and_another_channel_are_refused() {
    fn hmac(key: &[u8], parts: &[&[u8]]) -> [u8; 32] {
        let mut mac = Hmac::<Sha256>::new_from_slice(key).unwrap();
        parts.iter().for_each(|part| mac.update(part));
        mac.finalize().into_bytes().into()
    }
    fn attempts<M: Signed>(gate: &mut Gate, message: &M) {
        let encoded = message.encode().unwrap();
        let (body, _) = encoded.as_bytes().split_last_chunk::<16>().unwrap();
        let own = Author::LABELS[M::AUTHOR as usize];
        let channels = ["ROBOT_STATE", "SENSOR_DEFLECTION", "ROBOT_COMMAND", "TASK", ""];
        for (label, channel) in Author::LABELS
            .iter()
            .flat_map(|label| channels.map(|name| (*label, name)))
        {
            if (label, channel) == (own, M::CHANNEL) {
                continue;
            }
            let key = hmac(&secret(), &[label.as_bytes()]);
            let mut forged = *message;
            let tag = hmac(&key, &[channel.as_bytes(), &[0], body]);
            forged.authenticity_mut().tag.copy_from_slice(&tag[..16]);
            assert_eq!(gate.admit(&forged), Err(Refusal::Tag), "{label} on {channel}");
        }
        assert_eq!(gate.admit(message), Ok(()));
    }
    let mut cell = Cell::new();
    cell.settle(3);
    let said = cell.say(3);
    attempts(&mut cell.controller, &said.state);
    attempts(&mut cell.controller, &said.deflections);
    attempts(&mut cell.robot, &said.command);
    attempts(&mut cell.robot, &said.task);
}
