//! What the readings of a channel have come to, in words.

use crate::stream::wire::ChannelStats;
use crate::units::{ForceUnit, rough};

/// Rate, shares of what they were, and uncertainties; `value_unit`: of what a law gives.
pub fn in_words(stats: &ChannelStats, unit: ForceUnit, value_unit: &str) -> String {
    let percent = |count: u64| {
        let percent = 100.0 * count as f64 / stats.readings.max(1) as f64;
        if percent > 0.0 && percent < 1.0 { "below 1 %".to_owned() } else { format!("{percent:.0} %") }
    };
    let share = |count: u64, name: &str| (count > 0).then(|| format!("{} {name}", percent(count)));
    let among = [share(stats.moving, "moving"), share(stats.settling, "settling")];
    let among: Vec<String> = among.into_iter().flatten().collect();
    let among = if among.is_empty() { String::new() } else { format!(" ({})", among.join(", ")) };
    let rate = stats.rate_hz.map(|rate| format!("{rate:.1}/s"));
    let shares = [
        Some(format!("{} ok{among}", percent(stats.ok))),
        share(stats.open, "open"),
        share(stats.short, "short"),
        share(stats.faults, "faults"),
    ];
    let u_ohm = stats.r_u_ohm.map(|u| rough(u, "ohm"));
    let u_n = stats.f_u_n.map(|u| rough(u / unit.newton(), unit.as_str()));
    let u_value = stats.value_u.map(|u| rough(u, value_unit));
    let u = u_ohm.into_iter().chain(u_n).chain(u_value).collect::<Vec<_>>().join(" and ");
    let u = (!u.is_empty()).then(|| format!("u {u} rms"));
    rate.into_iter().chain(shares.into_iter().flatten()).chain(u).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_there_is_not_named() {
        let stats = ChannelStats {
            span_s: 9.5,
            readings: 400,
            rate_hz: Some(42.0),
            r_u_ohm: Some(1.234),
            f_u_n: Some(0.0123),
            ok: 390,
            moving: 40,
            open: 8,
            faults: 2,
            ..ChannelStats::default()
        };
        assert_eq!(
            in_words(&stats, ForceUnit::Gram, ""),
            "42.0/s, 98 % ok (10 % moving), 2 % open, below 1 % faults, u 1.23 ohm and 1.25 g rms"
        );
        let warm = ChannelStats { f_u_n: None, value_u: Some(0.0456), ..stats };
        assert!(in_words(&warm, ForceUnit::Gram, "degC").ends_with("u 1.23 ohm and 0.0456 degC rms"));
        let none = ChannelStats { readings: 1, faults: 1, ..ChannelStats::default() };
        assert_eq!(in_words(&none, ForceUnit::Newton, ""), "0 % ok, 100 % faults");
    }
}
