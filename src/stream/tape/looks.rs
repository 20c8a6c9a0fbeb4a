//! What looks had shown before a tape began: it has too few of them to find that again.

use crate::stream::limits::{LARGEST_LEAK_SIEMENS, LONGEST_NS};
use crate::stream::line::{is_unknown, is_unknown_pair, pair, uncertainty};
use serde::{Deserialize, Serialize};

/// What was known of defects when a tape began; what is absent is not known, and not in the uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct TapeLooks {
    /// What leaks at node A in discharges that were held early and late on their way, siemens; what feeds it, negative.
    #[serde(serialize_with = "pair", skip_serializing_if = "is_unknown_pair")]
    pub leak_siemens: Option<[f64; 2]>,
    /// 1 sigma of each, siemens.
    #[serde(serialize_with = "pair", skip_serializing_if = "is_unknown_pair")]
    pub leak_u_siemens: Option<[f64; 2]>,
    /// What node B loses more than A meanwhile, siemens; absent where nobody waited for it.
    #[serde(serialize_with = "pair", skip_serializing_if = "is_unknown_pair")]
    pub leak_b_siemens: Option<[f64; 2]>,
    /// 1 sigma of each, siemens.
    #[serde(serialize_with = "pair", skip_serializing_if = "is_unknown_pair")]
    pub leak_b_u_siemens: Option<[f64; 2]>,
    /// By how much longer discharges through R_1 and R_2 are when the program wakes before their end, ns: stamps are later or
    /// earlier by so much after waits as long.
    #[serde(serialize_with = "pair", skip_serializing_if = "is_unknown_pair")]
    pub late_ns: Option<[f64; 2]>,
    /// 1 sigma of each, ns.
    #[serde(serialize_with = "pair", skip_serializing_if = "is_unknown_pair")]
    pub late_u_ns: Option<[f64; 2]>,
    /// By which share of their time discharges are longer after a rest.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub absorbed: Option<f64>,
}

impl TapeLooks {
    pub(super) fn check(&self) -> Result<(), String> {
        let (leak, late) = (LARGEST_LEAK_SIEMENS, LONGEST_NS);
        let absorbed = self.absorbed.map(|share| [share; 2]);
        for (name, pair, [least, greatest]) in [
            ("leak_siemens", self.leak_siemens, [-leak, leak]),
            ("leak_u_siemens", self.leak_u_siemens, [0.0, leak]),
            ("leak_b_siemens", self.leak_b_siemens, [-leak, leak]),
            ("leak_b_u_siemens", self.leak_b_u_siemens, [0.0, leak]),
            ("late_ns", self.late_ns, [-late, late]),
            ("late_u_ns", self.late_u_ns, [0.0, late]),
            ("absorbed", absorbed, [0.0, 1.0]),
        ] {
            let wrong = pair.into_iter().flatten().find(|value| !(least..=greatest).contains(value));
            if let Some(value) = wrong {
                return Err(super::check::beyond(name, value, [least, greatest]));
            }
        }
        let halves = [
            ("leak_siemens", "leak_u_siemens", self.leak_siemens, self.leak_u_siemens),
            ("leak_b_siemens", "leak_b_u_siemens", self.leak_b_siemens, self.leak_b_u_siemens),
            ("late_ns", "late_u_ns", self.late_ns, self.late_u_ns),
        ];
        match halves.into_iter().find(|(_, _, value, u)| value.is_some() != u.is_some()) {
            Some((value, u, ..)) => Err(format!("{value} and {u} belong together: leave both away, or none")),
            None => Ok(()),
        }
    }
}
