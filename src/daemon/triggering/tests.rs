//! The thread without a daemon around it.

use super::*;
use crate::reading::{Bound, Method, Status};
use crate::trigger::{Compared, TriggerRules, Why};

const STALE: Nanos = Nanos(200_000_000);

fn settings(channel: usize) -> TriggerSettings {
    let rules =
        TriggerRules { quantity: Compared::Shown, on: 2.0, off: 1.0, hold: Nanos::ZERO, stale: STALE };
    let [chip, line, consumer] = ["simulated", "GPIO17", "cermd"].map(str::to_owned);
    let line = OutputLine { chip, line, active_low: false, consumer };
    TriggerSettings { channel, id: format!("x{channel}"), rules, output: Some((line, When::Pressed)) }
}

fn start(triggers: Vec<TriggerSettings>) -> (Triggering, Tap) {
    let outputs = open(&triggers, Way::Simulated).unwrap();
    Triggering::start(triggers, outputs, Way::Simulated, &Wishes::default()).unwrap()
}

fn pressed(channel: usize, at: Nanos) -> Reading {
    Reading {
        channel,
        seq: 1,
        at,
        status: Status::Short { r_max_ohm: 4.0, shown: Some(Bound::AtLeast(500.0)) },
        suspect: None,
        method: Method::Tracked,
        duration: Nanos::ZERO,
    }
}

/// Waits for what is told next.
fn next(triggering: &mut Triggering) -> Vec<ChannelEvent> {
    let until = monotonic() + Nanos(20_000_000_000);
    loop {
        let told = triggering.take();
        if !told.is_empty() {
            return told;
        }
        assert!(monotonic() < until, "nothing is told");
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_measuring_thread_that_hangs_is_noticed() {
    let (mut triggering, mut tap) = start(vec![settings(0), settings(2)]);
    let at = monotonic();
    // The first of no channel with a trigger.
    for channel in [1, 2, 7] {
        tap.give(&pressed(channel, at));
    }
    assert_eq!(
        next(&mut triggering),
        [ChannelEvent { channel: 2, event: Event { state: State::Pressed, at } }]
    );
    let beat = triggering.beat();
    let [ChannelEvent { channel: 2, event }] = next(&mut triggering)[..] else { panic!() };
    assert_eq!(event.state, State::Unknown(Why::Stale));
    assert!(event.at - at >= STALE);
    // It naps, and still shows that it is alive.
    thread::sleep(Duration::from_nanos(3 * NAP.0.unsigned_abs()));
    assert!(triggering.beat() > beat && !triggering.has_ended() && triggering.take().is_empty());
}

#[test]
fn an_output_that_cannot_be_had_is_tried_again_and_delays_nothing() {
    let triggers = vec![settings(0)];
    // As after a reload that has failed; no chip has this name.
    let (mut triggering, mut tap) =
        Triggering::start(triggers, vec![None], Way::V2, &Wishes::default()).unwrap();
    let at = monotonic();
    tap.give(&pressed(0, at));
    assert_eq!(
        next(&mut triggering),
        [ChannelEvent { channel: 0, event: Event { state: State::Pressed, at } }]
    );
}

/// Whoever was told "pressed" must not believe it for ever.
#[test]
fn a_stop_says_that_nothing_is_known_any_more() {
    let (mut triggering, mut tap) = start(vec![settings(0), settings(1)]);
    let at = monotonic();
    tap.give(&pressed(0, at));
    next(&mut triggering);
    triggering.stop();
    let [ChannelEvent { channel: 0, event }] = triggering.take()[..] else { panic!() };
    assert!(matches!(event.state, State::Unknown(_)) && event.at >= at, "{event:?}");
}
