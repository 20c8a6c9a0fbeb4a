//! The configuration of a circuit, as somebody would write it who is about to build it.

use super::asked::{Asked, chip_of};
use crate::circuit::Network;
use crate::config::Config;
use crate::ctl::CtlError;
use crate::size::{Design, Pace};
use crate::units::{Ohm, Seconds, rounded};
use std::fmt::Write;

/// Its text.
pub fn text(asked: &Asked, design: &Design) -> String {
    [circuit(asked, design), lines(asked, design), measure(design), channel(asked, design)].concat()
}

/// The same, read again: what is promised is promised of what is written.
pub fn parsed(asked: &Asked, design: &Design) -> Result<Config, CtlError> {
    Ok(Config::parse(&text(asked, design), "the configuration that size writes")?)
}

fn circuit(asked: &Asked, design: &Design) -> String {
    let (platform, [r_c1, r_c2]) = (&asked.search.platform, design.r_c);
    let mut text = format!(
        "# Written by `cermctl size` for board {}, whose noise is simulated. To build: hw/wiring.md.\n\n[circuit]\nkind = \"{}\"\n\
         # As printed. Film; they never enter a reading.\n",
        asked.name,
        design.kind(),
    );
    let capacitors = match design.network {
        Network::TwoCapacitor { c_a, c_b } => format!("c-a = \"{c_a}\"\nc-b = \"{c_b}\"\n"),
        Network::OneCapacitor { c } | Network::SeriesCalibration { c } => format!("c = \"{c}\"\n"),
    };
    let _ = write!(
        text,
        "{capacitors}# MEASURE both before soldering and write what the ohmmeter shows: a reading is as true as these.\n\
         r-c1 = \"{r_c1}\"\nr-c2 = \"{r_c2}\"\n\
         # Nominal, for planning only: supply, threshold of an input, and Rp = {} with a pin of {}.\n\
         v-dd = \"{}\"\nv-th = \"{}\"\nr-charge = \"{}\"\n",
        design.r_p,
        platform.r_o,
        platform.v_dd,
        platform.v_th,
        Ohm(design.r_p.0 + platform.r_o.0),
    );
    text
}

fn lines(asked: &Asked, design: &Design) -> String {
    let chip = chip_of(&asked.name);
    let b = |line: &str| if design.nodes() == 2 { line.to_owned() } else { String::new() };
    format!(
        "\n[gpio]\nbackend = \"chardev\"\n# `cermctl lines` shows what there is.\nchip = \"{chip}\"\nsense-a = \"GPIO5\"\n{}\
         charge-a = \"GPIO13\"\n{}sink-c1 = \"GPIO20\"\nsink-c2 = \"GPIO21\"\n",
        b("sense-b = \"GPIO6\"\n"),
        b("charge-b = \"GPIO19\"\n"),
    )
}

fn measure(design: &Design) -> String {
    let mut text = "\n[measure]\nmethod = \"tracked\"\n".to_owned();
    let _ = match design.pace {
        Pace::Each => writeln!(text, "# Each discharge a reading."),
        Pace::Mean(time) => writeln!(text, "average = \"{}\"", Seconds::from(time)),
        Pace::Hertz(hertz) => writeln!(text, "rate-hz = {}", rounded(hertz, 3)),
    };
    if let Some(deadline) = design.deadline {
        let _ =
            writeln!(text, "# Shorter than usual, for the rate.\ndeadline = \"{}\"", Seconds::from(deadline));
    }
    text
}

fn channel(asked: &Asked, design: &Design) -> String {
    let mut text = format!(
        "\n[[channel]]\nid = \"sensor\"\nsink = \"GPIO16\"\n\
         # MEASURE: with a short circuit in the sensor's place `cermctl calibrate zero` writes zero-ohm here, about {} (R_lim)\n\
         # and what pins differ by; then `cermctl calibrate reference OHM` with a known resistor writes scale.\n",
        design.r_lim,
    );
    if let Some(alpha_n_ohm) = asked.alpha_n_ohm {
        let _ = writeln!(
            text,
            "# Of a usual FSR 402. MEASURE yours: `cermctl calibrate force`.\nforce = {{ alpha = \"{alpha_n_ohm} N ohm\" }}"
        );
    }
    text
}
