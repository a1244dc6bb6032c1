//! Publishing and receiving, in memory and over multicast.

use crate::draw::Counting;
use crate::samples::Sample;
use crate::{expect, udpm_url};
use crossbeam::select;
use lcmtypes::{Inboxes, LcmBuilder, LcmError, Message, RawMessage, Received, Refusal, Subscription, Woken};
use spatial::ports::*;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

pub(crate) const PATIENCE: Duration = Duration::from_secs(10);

pub(crate) fn next<M: Clone>(subscription: &Subscription<M>) -> M {
    subscription
        .receiver()
        .recv_timeout(PATIENCE)
        .expect("a message within 10 s")
        .message
}

/// In memory, over multicast, and over multicast received by liblcm.
fn urls() -> [String; 3] {
    let multicast = udpm_url();
    let liblcm = format!("{multicast}&receive=liblcm");
    ["memq://".to_owned(), multicast, liblcm]
}

fn task(step: i64) -> Task {
    Task {
        stamp: Stamp {
            step,
            ..Stamp::default()
        },
        ..Task::default()
    }
}

#[test]
fn a_message_arrives_as_it_was_published() {
    for url in urls() {
        let mut builder = expect(LcmBuilder::open(&url));
        let states = builder.subscribe::<RobotState>(8);
        let tasks = builder.subscribe::<Task>(8);
        let lcm = expect(builder.start());
        let sent = RobotState::sample(&mut Counting::default());
        expect(lcm.publish(&sent));
        let received = select! {
            recv(states.receiver()) -> received => received.unwrap(),
            recv(tasks.receiver()) -> _ => panic!("a message on another channel"),
            default(PATIENCE) => panic!("nothing within 10 s on {url}"),
        };
        assert_eq!(received.message, sent);
        assert_eq!(states.counters().received, 1);
        assert_eq!(lcm.counters().received, 1);
        assert_eq!(tasks.counters(), Default::default());
    }
}

#[test]
fn an_encoding_can_be_published_again() {
    let mut builder = expect(LcmBuilder::open(&udpm_url()));
    let all = builder.subscribe_all(8);
    let lcm = expect(builder.start());
    let encoded = Truth::sample(&mut Counting::default()).encode().unwrap();
    for _ in 0..3 {
        expect(lcm.publish_encoded(&encoded));
        let expected = RawMessage {
            channel: "SIM_TRUTH".to_owned(),
            bytes: encoded.as_bytes().to_vec(),
        };
        assert_eq!(next(&all), expected);
    }
}

#[test]
fn a_full_queue_keeps_the_newest() {
    for url in urls() {
        let mut builder = expect(LcmBuilder::open(&url));
        let tasks = builder.subscribe::<Task>(2);
        let all = builder.subscribe_all(8);
        let lcm = expect(builder.start());
        for step in 1..=5 {
            expect(lcm.publish(&task(step)));
        }
        // Subscriptions are served in their order: what `all` has, `tasks` has had.
        (0..5).for_each(|_| drop(next(&all)));
        assert_eq!([next(&tasks).stamp.step, next(&tasks).stamp.step], [4, 5]);
        assert!(tasks.receiver().is_empty());
        assert_eq!((tasks.counters().received, tasks.counters().dropped), (5, 3));
        assert_eq!(lcm.counters().dropped, 3);
    }
}

#[test]
fn a_channel_is_matched_by_its_whole_name() {
    for url in urls() {
        let mut builder = expect(LcmBuilder::open(&url));
        let tasks = builder.subscribe::<Task>(8);
        let lcm = expect(builder.start());
        let encoded = task(1).encode().unwrap();
        for channel in ["TASKS", "A_TASK", "T.SK", ".*", "task", "TAS"] {
            expect(lcm.publish_raw(channel, encoded.as_bytes()));
        }
        expect(lcm.publish(&task(2)));
        assert_eq!(next(&tasks).stamp.step, 2);
        assert_eq!(tasks.counters().received, 1);
    }
}

/// Cells that share group and port: each hears its own messages alone, under their plain names.
#[test]
fn cells_with_suffixes_do_not_hear_each_other() {
    for url in urls().into_iter().skip(1) {
        let cells = ["", "&suffix=_B", "&suffix=_B_2"].map(|suffix| {
            let mut builder = expect(LcmBuilder::open(&format!("{url}{suffix}")));
            let tasks = builder.subscribe::<Task>(8);
            let all = builder.subscribe_all(8);
            (tasks, all, expect(builder.start()))
        });
        for (step, (.., link)) in (0..).zip(&cells) {
            expect(link.publish(&task(step)));
        }
        // What comes after all others have been heard.
        for (step, (tasks, all, link)) in (0..).zip(&cells) {
            expect(link.publish_raw("TASK", task(step + 10).encode().unwrap().as_bytes()));
            assert_eq!(
                [next(tasks), next(tasks)].map(|it| it.stamp.step),
                [step, step + 10]
            );
            assert_eq!(tasks.counters().received, 2);
            if step > 0 {
                assert_eq!([next(all), next(all)].map(|it| it.channel), ["TASK", "TASK"]);
            }
        }
        // Who has no suffix hears of the others, as of any stranger's.
        let (_, all, _) = &cells[0];
        let mut heard: Vec<_> = (0..6).map(|_| next(all).channel).collect();
        heard.sort();
        assert_eq!(
            heard,
            ["TASK", "TASK", "TASK_B", "TASK_B", "TASK_B_2", "TASK_B_2"]
        );
    }
}

#[test]
fn an_undecodable_message_is_counted_and_explained() {
    for url in urls() {
        let mut builder = expect(LcmBuilder::open(&url));
        let tasks = builder.subscribe::<Task>(8);
        let lcm = expect(builder.start());
        expect(lcm.publish_raw("TASK", &[]));
        expect(lcm.publish_raw("TASK", &[1; 224]));
        expect(lcm.publish(&task(1)));
        assert_eq!(next(&tasks).stamp.step, 1);
        assert_eq!((tasks.counters().undecodable, lcm.counters().undecodable), (2, 2));
        let refusal = tasks.last_refusal().map(|refusal| refusal.to_string());
        assert!(
            refusal
                .is_some_and(|text| text.starts_with("TASK carries fingerprint 0x0101010101010101, not 0x"))
        );
        assert!(matches!(lcm.last_refusal(), Some(Refusal::Undecodable(_))));
    }
}

#[test]
fn a_link_that_ends_disconnects_its_subscriptions() {
    for url in urls() {
        let mut builder = expect(LcmBuilder::open(&url));
        let tasks = builder.subscribe::<Task>(8);
        let all = builder.subscribe_all(8);
        let lcm = expect(builder.start());
        expect(lcm.publish(&task(1)));
        next(&all);
        drop(lcm);
        let last: Vec<Received<Task>> = tasks.receiver().iter().collect();
        assert_eq!(last.len(), 1);
    }
}

#[test]
fn any_thread_may_publish() {
    let url = udpm_url();
    let mut builder = expect(LcmBuilder::open(&url));
    let tasks = builder.subscribe::<Task>(100);
    let _receiving = expect(builder.start());
    let lcm = expect(expect(LcmBuilder::open(&url)).start());
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let lcm = &lcm;
            scope.spawn(move || (0..25).for_each(|i| expect(lcm.publish(&task(25 * thread + i)))));
        }
    });
    let mut steps: Vec<i64> = (0..100).map(|_| next(&tasks).stamp.step).collect();
    steps.sort_unstable();
    assert_eq!(steps, (0..100).collect::<Vec<_>>());
}

#[test]
fn nothing_unchecked_is_published() {
    let lcm = expect(expect(LcmBuilder::open("memq://")).start());
    let mut state = RobotState::sample(&mut Counting::default());
    state.sample_count = 0;
    let error = lcm.publish(&state).unwrap_err().to_string();
    assert_eq!(
        error,
        "ROBOT_STATE is not published: robot_sample_count is 0, outside 1..=8; the message is refused"
    );
    for channel in ["", "A\0B", &"X".repeat(64)] {
        assert!(matches!(
            lcm.publish_raw(channel, &[]),
            Err(LcmError::ChannelName(_))
        ));
    }
}

/// A thread that receives by itself gets what has come to all its links, is woken for it and when it is to stop.
#[test]
fn a_thread_receives_from_its_links_by_itself() {
    for url in urls() {
        let (stop, sender) = UnixStream::pair().unwrap();
        let mut inboxes = Inboxes::new(stop);
        let mut builders = [&url, "memq://"].map(|url| expect(LcmBuilder::open(url)));
        let tasks = [0, 1].map(|i| builders[i].subscribe::<Task>(8));
        let links = builders.map(|builder| expect(inboxes.start(builder)));
        assert_eq!(
            inboxes.wait(Some(Duration::ZERO)).unwrap(),
            Woken::Nothing,
            "{url}"
        );
        for (i, step) in [(0, 1), (1, 2), (0, 3)] {
            expect(links[i].publish(&task(step)));
        }
        let mut steps = [Vec::new(), Vec::new()];
        while steps.iter().map(Vec::len).sum::<usize>() < 3 {
            assert_eq!(inboxes.wait(Some(PATIENCE)).unwrap(), Woken::Messages, "{url}");
            for (steps, tasks) in steps.iter_mut().zip(&tasks) {
                steps.extend(std::iter::from_fn(|| tasks.take()).map(|it| it.message.stamp.step));
            }
        }
        assert_eq!(steps, [vec![1, 3], vec![2]], "{url}");
        assert!(tasks[0].take().is_none());
        let third = expect(LcmBuilder::open("memq://"));
        assert!(matches!(inboxes.start(third), Err(LcmError::Links { most: 2 })));
        drop(sender);
        assert_eq!(inboxes.wait(None).unwrap(), Woken::Stopped, "{url}");
    }
}

/// However late the thread looks, the kernel knows when a message came.
#[test]
#[expect(clippy::disallowed_methods, reason = "compares receive stamps")]
fn a_message_that_has_waited_tells_when_it_came() {
    let (stop, _sender) = UnixStream::pair().unwrap();
    let mut inboxes = Inboxes::new(stop);
    let mut builder = expect(LcmBuilder::open(&udpm_url()));
    let tasks = builder.subscribe::<Task>(8);
    let link = expect(inboxes.start(builder));
    let mut waited = |step| {
        let sent = Instant::now();
        expect(link.publish(&task(step)));
        let looked = Instant::now();
        assert_eq!(inboxes.wait(Some(PATIENCE)).unwrap(), Woken::Messages);
        let received = tasks.take().unwrap();
        assert_eq!(received.message.stamp.step, step);
        assert!(received.received_at >= sent);
        received.received_at < looked
    };
    // Loopback delivers within the call that sends. Not each time: the stamp may be read just before the thread is held up.
    assert!((0..100).any(&mut waited));
}
