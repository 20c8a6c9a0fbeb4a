//! Where each method holds and where it fails, in simulated circuits and virtual time.
//!
//! A scenario is a board with something changed; each is checked from both sides against a prediction of the law, and every
//! seed is fixed. `docs/stability.md` is what comes out of it; `UPDATE_DOCS=1 cargo test --test stability` writes it anew.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot be set up fails")]

mod by_hand;
mod charged;
mod circuit;
#[path = "../common/mod.rs"]
mod common;
mod dielectrics;
mod disturbed;
mod events;
mod failures;
mod interruptions;
mod leaks;
mod noise;
mod one_capacitor;
mod paper;
mod picture;
mod scenario;
mod states;
mod switching;

use cermd::reading::Method;
use scenario::Scenario;
use std::sync::OnceLock;

/// The scenarios in the order of the table, each of them a test; the table takes what these have found.
macro_rules! scenarios {
    ($($name:ident: $run:path,)*) => {
        mod scenarios {
            $(
                #[test]
                fn $name() {
                    let scenario = super::of(super::Name::$name);
                    assert!(scenario.wrong.is_empty(), "\n{}", scenario.wrong);
                }
            )*
        }

        #[allow(non_camel_case_types, reason = "the names of the tests")]
        #[derive(Clone, Copy)]
        enum Name { $($name,)* }

        const SCENARIOS: &[fn() -> Scenario] = &[$($run,)*];
    };
}

scenarios! {
    a_switch_in_reaction: switching::reaction,
    an_uncorrected_offset: switching::offset,
    quantisation: noise::quantisation,
    trigger_noise: noise::trigger,
    wide_band_noise_at_low_resistance: noise::wide_band_low,
    wide_band_noise_at_high_resistance: noise::wide_band_high,
    spikes: noise::spikes,
    the_threshold_t_l: switching::threshold,
    an_early_switch: switching::denominator,
    node_b_near_its_limit: circuit::node_b,
    close_calibration_resistors: circuit::close_resistors,
    slow_drift: circuit::slow_drift,
    fast_drift: circuit::fast_drift,
    a_restless_supply: circuit::restless_supply,
    one_ohm: switching::one_ohm,
    ten_megohm: circuit::ten_megohm,
    preempted_while_it_starts: interruptions::at_the_start,
    preempted_before_the_start: interruptions::before_the_start,
    preempted_before_a_switch: interruptions::before_the_switch,
    preempted_within_a_switch: interruptions::within_the_switch,
    preempted_while_it_waits: interruptions::while_it_waits,
    a_step_of_the_wall_clock: interruptions::wall_clock,
    suspended_within_a_discharge: interruptions::suspended,
    suspended_for_hours: interruptions::suspended_for_hours,
    lost_edges: events::lost_edges,
    a_full_event_buffer: events::full_buffer,
    capacitors_of_polypropylene: dielectrics::pp,
    capacitors_of_polyester: dielectrics::pet,
    capacitors_of_c0g: dielectrics::c0g,
    capacitors_of_x7r: dielectrics::x7r,
    one_capacitor: one_capacitor::alone,
    one_capacitor_that_drifts: one_capacitor::drifting,
    one_capacitor_and_late_stamps: one_capacitor::spikes,
}

static FOUND: [OnceLock<Scenario>; SCENARIOS.len()] = [const { OnceLock::new() }; SCENARIOS.len()];

fn of(name: Name) -> &'static Scenario {
    FOUND[name as usize].get_or_init(SCENARIOS[name as usize])
}

const HEAD: &str = "# Where each method holds, and where it fails

![Error and honesty over resistance and jitter of stamps: which cells fail, and by which cause](map-jitter.svg)

The picture is of `cermctl characterize`, which has such maps of leakage, of a wrong offset and others, too.

All of this is **simulated**, in virtual time, with the seeds that the tests name; none was measured on hardware. Written by
`UPDATE_DOCS=1 cargo test --test stability`; do not edit.
";

const LEGEND: &str = "
- ✔ *holds*: the numbers are as good as the row asks for.
- ! *told*: they are not, or there are none, and each reading says so, by its uncertainty or by a state in the place of a number.
- ✘ *fails*: they are not, and nobody is told.
";

const TABLE: &str = "
## By method

What the picture shows, with its figures. *published*: the equations of the papers on the same discharges, without any of our rules;
all other figures are those of our methods. Board `pi4` (2.2 uF / 680 nF, or 470 nF for `qerm`; Rc 470 and 12700 ohm) without its rare long
delays, where the row says nothing else. *error* is the root mean square, *in 2u* the share of numbers that are off by less than two of
their own sigma, *wrong* a number that is off by more than 5 sigma and 1 %. The signs are by the row's own criterion. The test asserts each
of them, and that what fails fails as the law of the circuit predicts, from both sides. – : the method does not do what the row is about.
";

/// What the picture comes to.
fn in_short(groups: &[(&str, Vec<picture::Row>)]) -> String {
    let [[p_holds, _, p_fails], [holds, told, fails]] =
        [false, true].map(|is_ours| picture::counts(groups, is_ours));
    let published = p_holds + p_fails;
    let ours = holds + told + fails;
    format!(
        "In short: where the published equations were tried beside ours, they fail in {p_fails} of {published} cells. Ours hold in \
         {holds} of {ours}, tell of the trouble in {told}, and are wrong without saying so in {fails}.\n"
    )
}

/// Writes the page if that is asked for; otherwise it has to be what it would be.
#[test]
fn the_page_is_up_to_date() {
    let scenarios: Vec<&Scenario> =
        FOUND.iter().zip(SCENARIOS).map(|(found, run)| found.get_or_init(run)).collect();
    let methods: Vec<&str> = Method::ALL.iter().map(|method| method.as_str()).collect();
    let (defects, ill, wrong) = states::report();
    let groups = [
        (
            "Noise, drift, late stamps, a busy system",
            scenarios.iter().map(|scenario| scenario.picture()).collect(),
        ),
        ("Defects of the circuit (a sensor of 1 kohm)", ill),
    ];
    let mut page = format!(
        "{HEAD}\n![What is wrong with a board, and how each method fares](stability.svg)\n{LEGEND}\n{}{TABLE}\n\
         | # | what is wrong | holds if | {} |\n|--:|---|---|{}\n",
        in_short(&groups),
        methods.join(" | "),
        "---|".repeat(methods.len())
    );
    for (number, scenario) in (1..).zip(&scenarios) {
        page += &scenario.row(number);
        page.push('\n');
    }
    page.push_str("\nWhy:\n\n");
    for (number, scenario) in (1..).zip(&scenarios) {
        page += &format!("{number}. {}\n", scenario.why);
    }
    let (leaks, unseen) = leaks::report();
    let (dielectrics, unlike) = dielectrics::report();
    page += &format!("\n{defects}{leaks}\n{dielectrics}");
    // The page is that of the first family of seeds; that nothing is wrong holds for all.
    assert!(wrong.is_empty() && unseen.is_empty() && unlike.is_empty(), "{wrong}{unseen}{unlike}");
    common::check_page("stability", "stability.svg", &picture::svg(&methods, &groups));
    common::check_page("stability", "stability.md", &page);
}
