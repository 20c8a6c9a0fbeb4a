//! What the estimates of a tape come to: how many, their mean, how they scatter, and whether their uncertainties say so.

use crate::ctl::replay::EstimateLine;
use crate::estimate::scatter;
use crate::stream::wire::StatusName;
use crate::units::sample::rms;
use crate::units::{measured, rounded};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Numbers with their uncertainties.
type Numbers = Vec<(f64, Option<f64>)>;

/// How many estimates are no number, by what they are instead.
type Others = BTreeMap<String, u64>;

/// The estimates by channel and method.
#[derive(Debug, Default)]
pub struct Summary(BTreeMap<[String; 2], (Numbers, Others)>);

/// Those of one channel by one method; what is not known is absent.
#[derive(Debug, Serialize)]
#[serde(tag = "class", rename = "SUMMARY")]
pub struct SummaryLine {
    channel: String,
    method: String,
    /// How many numbers there are, and how many estimates are none.
    n: usize,
    others: u64,
    #[serde(skip)]
    names: Others,
    #[serde(skip_serializing_if = "Option::is_none")]
    r_mean_ohm: Option<f64>,
    /// Of the scatter of single numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    r_sd_ohm: Option<f64>,
    /// What they state, root mean square.
    #[serde(skip_serializing_if = "Option::is_none")]
    r_u_ohm: Option<f64>,
    /// Root mean square of the deviations from the mean, each in units of its own uncertainty: 1 is honest.
    #[serde(skip_serializing_if = "Option::is_none")]
    rms_u: Option<f64>,
}

impl Summary {
    /// One more.
    pub fn add(&mut self, estimate: EstimateLine) {
        let method = estimate.state.method.unwrap_or_default();
        let (numbers, others) = self.0.entry([estimate.channel, method]).or_default();
        match estimate.state.r_ohm {
            Some(r_ohm) => numbers.push((r_ohm, estimate.state.r_u_ohm)),
            None => {
                let name = match estimate.state.status {
                    StatusName::Open => "open".to_owned(),
                    StatusName::Short => "short".to_owned(),
                    _ => estimate.state.fault.unwrap_or_default(),
                };
                *others.entry(name).or_default() += 1;
            }
        }
    }

    /// In the order of channels and methods.
    pub fn rows(&self) -> Vec<SummaryLine> {
        let rows = self.0.iter();
        rows.map(|([channel, method], (numbers, others))| SummaryLine::new(channel, method, numbers, others))
            .collect()
    }
}

impl SummaryLine {
    fn new(channel: &str, method: &str, numbers: &[(f64, Option<f64>)], others: &Others) -> SummaryLine {
        let n = numbers.len();
        let mean = scatter::mean(numbers.iter().map(|(r_ohm, _)| *r_ohm));
        let square = |of: &dyn Fn(f64, f64) -> f64| {
            rms(numbers.iter().filter_map(|(r_ohm, u)| Some(of(*r_ohm, (*u)?))))
        };
        // One degree of freedom is in the mean.
        let freedom = (n as f64 / (n as f64 - 1.0).max(1.0)).sqrt();
        let pulls = mean.filter(|_| n > 1).and_then(|mean| square(&|r_ohm, u| (r_ohm - mean.value) / u));
        let digits = |value: Option<f64>, digits| value.map(|value| rounded(value, digits));
        SummaryLine {
            channel: channel.to_owned(),
            method: method.to_owned(),
            n,
            others: others.values().sum(),
            names: others.clone(),
            r_mean_ohm: digits(mean.map(|mean| mean.value), 7),
            r_sd_ohm: digits(mean.and_then(|mean| mean.u).map(|u| u * (n as f64).sqrt()), 3),
            r_u_ohm: digits(square(&|_, u| u), 3),
            rms_u: digits(pulls.map(|pulls| pulls * freedom), 3),
        }
    }
}

impl fmt::Display for SummaryLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SummaryLine { channel, method, n, others, names, r_mean_ohm, r_sd_ohm, r_u_ohm, rms_u } = self;
        write!(f, "{channel}  {method}  n {n}")?;
        if *others > 0 {
            let names: Vec<String> = names.iter().map(|(name, count)| format!("{count} {name}")).collect();
            write!(f, " ({others} no number: {})", names.join(", "))?;
        }
        if let Some(mean) = r_mean_ohm {
            write!(
                f,
                "  mean {}",
                measured(*mean, r_sd_ohm.map(|sd| sd / (*n as f64).sqrt()), "ohm", false)
            )?;
        }
        for (name, value) in [("sd", r_sd_ohm), ("u", r_u_ohm)] {
            if let Some(value) = value {
                write!(f, "  {name} {value} ohm")?;
            }
        }
        if let Some(rms_u) = rms_u {
            write!(f, "  rms {rms_u} u")?;
        }
        writeln!(f)
    }
}
