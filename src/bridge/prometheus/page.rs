//! The page: the same metrics in the text format 0.0.4 and in OpenMetrics 1.0.
//!
//! What is unknown is absent, never 0 or NaN.

use crate::bridge::latest::Latest;
use crate::stream::wire::{ChannelInfo, ReadingLine, StateLine, StatsLine, StatusName, Unit};
use crate::units::Nanos;
use jiff::Timestamp;
use std::fmt::Write;

/// How it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Prometheus text, 0.0.4.
    Text,
    /// OpenMetrics, 1.0.
    OpenMetrics,
}

impl Format {
    /// What a header Accept asks for; without a wish, text.
    pub fn of(accept: &str) -> Format {
        let is_wanted = |range: &str| {
            let mut parts = range.split(';').map(str::trim);
            parts.next() == Some("application/openmetrics-text") && parts.all(|part| part != "q=0")
        };
        if accept.split(',').any(is_wanted) { Format::OpenMetrics } else { Format::Text }
    }

    pub fn content_type(self) -> &'static str {
        match self {
            Format::Text => "text/plain; version=0.0.4; charset=utf-8",
            Format::OpenMetrics => "application/openmetrics-text; version=1.0.0; charset=utf-8",
        }
    }
}

/// The page as it is at this instant of `CLOCK_MONOTONIC`.
pub fn render(latest: &Latest, now: Nanos, format: Format) -> String {
    let mut page = Exposition { format, text: String::new() };
    page.one(
        GAUGE,
        "cermd_up",
        "",
        "Whether the daemon answers.",
        Some(f64::from(latest.version().is_some())),
    );
    if let Some(version) = latest.version() {
        let release = vec![("version", &*version.release)];
        page.family(INFO, "cermd_build", "", "The release of the daemon.", vec![(release, 1.0)]);
    }
    readings(&mut page, &latest.fresh(now).collect::<Vec<_>>());
    let pressed = latest.pressed().map(|(id, is_pressed)| (vec![("channel", id)], f64::from(is_pressed)));
    let help = "Whether the trigger of the channel is pressed; absent: not known.";
    page.family(GAUGE, "cermd_pressed", "", help, pressed.collect());
    if let Some(stats) = latest.stats() {
        figures(&mut page, stats);
    }
    if format == Format::OpenMetrics {
        page.text += "# EOF\n";
    }
    page.text
}

type Labels<'a> = Vec<(&'static str, &'a str)>;

/// What a family is: its type in text, in OpenMetrics, and what OpenMetrics adds to its name in samples.
type Family = (&'static str, &'static str, &'static str);
const GAUGE: Family = ("gauge", "gauge", "");
const COUNTER: Family = ("counter", "counter", "_total");
const INFO: Family = ("gauge", "info", "_info");

struct Exposition {
    format: Format,
    text: String,
}

impl Exposition {
    /// A family of samples; without any, nothing.
    fn family(&mut self, kind: Family, name: &str, unit: &str, help: &str, samples: Vec<(Labels<'_>, f64)>) {
        if samples.is_empty() {
            return;
        }
        let (text, open, suffix) = kind;
        // In text the family is called as its samples are.
        let (family, kind) = match self.format {
            Format::Text => (format!("{name}{suffix}"), text),
            Format::OpenMetrics => (name.to_owned(), open),
        };
        let _ = writeln!(self.text, "# HELP {family} {help}\n# TYPE {family} {kind}");
        if self.format == Format::OpenMetrics && !unit.is_empty() {
            let _ = writeln!(self.text, "# UNIT {family} {unit}");
        }
        for (labels, value) in samples {
            let labels: Vec<_> =
                labels.into_iter().map(|(key, value)| format!("{key}=\"{}\"", escaped(value))).collect();
            let labels = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
            let _ = writeln!(self.text, "{name}{suffix}{labels} {value}");
        }
    }

    fn one(&mut self, kind: Family, name: &str, unit: &str, help: &str, value: Option<f64>) {
        self.family(kind, name, unit, help, value.map(|value| (Vec::new(), value)).into_iter().collect());
    }
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

/// A number that a reading may have: name, unit, help, and where it is.
type Metric = (&'static str, &'static str, &'static str, fn(&StateLine) -> Option<f64>);

const NUMBERS: [Metric; 12] = [
    ("cermd_resistance_ohms", "ohms", "The resistance of the sensor.", |s| s.r_ohm),
    ("cermd_resistance_uncertainty_ohms", "ohms", "Its uncertainty, 1 sigma.", |s| s.r_u_ohm),
    ("cermd_resistance_lower_bound_ohms", "ohms", "Open: it is above.", |s| s.r_min_ohm),
    ("cermd_resistance_upper_bound_ohms", "ohms", "Short: it is below.", |s| s.r_max_ohm),
    ("cermd_force_newtons", "newtons", "The force on the sensor.", |s| s.f_n),
    ("cermd_force_uncertainty_newtons", "newtons", "All of its uncertainty, 1 sigma.", |s| s.f_u_n),
    ("cermd_force_repeatability_newtons", "newtons", "That of the readout alone, 1 sigma.", |s| {
        s.f_repeat_u_n
    }),
    ("cermd_force_upper_bound_newtons", "newtons", "Open: the force is below.", |s| s.f_max_n),
    ("cermd_force_lower_bound_newtons", "newtons", "Short: the force is above.", |s| s.f_min_n),
    ("cermd_reading_extrapolated", "", "Whether force or value is outside of where its law holds.", |s| {
        s.f_n.or(s.value).filter(|_| s.unit.as_deref() != Some("ohm")).map(|_| f64::from(s.extrapolated))
    }),
    ("cermd_reading_moving", "", "Whether the sensor changed while it was read.", |s| {
        s.r_ohm.map(|_| f64::from(s.moving))
    }),
    ("cermd_reading_settling", "", "Whether the uncertainty is a guess.", |s| {
        s.r_ohm.map(|_| f64::from(s.settling))
    }),
];

/// What there may be of a channel; the last one: no fresh reading.
const STATUSES: [(&str, Option<StatusName>); 5] = [
    ("ok", Some(StatusName::Ok)),
    ("open", Some(StatusName::Open)),
    ("short", Some(StatusName::Short)),
    ("fault", Some(StatusName::Fault)),
    ("unknown", None),
];

fn readings(page: &mut Exposition, channels: &[(&ChannelInfo, Option<&ReadingLine>)]) {
    let known = || channels.iter().filter_map(|(channel, reading)| Some((&*channel.id, (*reading)?)));
    let mut statuses = Vec::new();
    for (channel, reading) in channels {
        let status = reading.map(|reading| reading.state.status);
        let labels = |name| vec![("channel", &*channel.id), ("status", name)];
        statuses.extend(STATUSES.map(|(name, is)| (labels(name), f64::from(is == status))));
    }
    let help = "1 for the state that the channel is in; unknown: no fresh reading.";
    page.family(GAUGE, "cermd_channel_status", "", help, statuses);
    let faults = known().filter_map(|(id, reading)| {
        Some((vec![("channel", id), ("fault", reading.state.fault.as_deref()?)], 1.0))
    });
    page.family(GAUGE, "cermd_channel_fault", "", "Why a channel has no number.", faults.collect());
    for (name, unit, help, number) in NUMBERS {
        let samples =
            known().filter_map(|(id, reading)| Some((vec![("channel", id)], number(&reading.state)?)));
        page.family(GAUGE, name, unit, help, samples.collect());
    }
    values(page, channels);
    let times = known().filter_map(|(id, reading)| {
        let time: Timestamp = reading.time.parse().ok()?;
        Some((vec![("channel", id)], time.as_nanosecond() as f64 * 1e-9))
    });
    let help = "When the reading was taken, in the time of Unix.";
    page.family(GAUGE, "cermd_reading_timestamp_seconds", "seconds", help, times.collect());
}

/// What laws give: any quantity, so the unit is a label.
fn values(page: &mut Exposition, channels: &[(&ChannelInfo, Option<&ReadingLine>)]) {
    const VALUES: [Metric; 5] = [
        ("cermd_value", "", "What the sensor shows by its law.", |s| s.value),
        ("cermd_value_uncertainty", "", "All of its uncertainty, 1 sigma.", |s| s.value_u),
        ("cermd_value_repeatability", "", "That of the readout alone, 1 sigma.", |s| s.value_repeat_u),
        ("cermd_value_lower_bound", "", "Open or short: the value is above.", |s| s.value_min),
        ("cermd_value_upper_bound", "", "Open or short: the value is below.", |s| s.value_max),
    ];
    let of_laws = || channels.iter().filter(|(channel, _)| matches!(channel.unit, Unit::Other(_)));
    for (name, unit, help, number) in VALUES {
        let samples = of_laws().filter_map(|(channel, reading)| {
            let labels = vec![("channel", &*channel.id), ("unit", channel.unit.as_str())];
            Some((labels, number(&(*reading)?.state)?))
        });
        page.family(GAUGE, name, unit, help, samples.collect());
    }
}

fn figures(page: &mut Exposition, stats: &StatsLine) {
    let of = &stats.instrument;
    let states = [("ok", of.ok), ("open", of.open), ("short", of.short), ("fault", of.faults.values().sum())];
    let states = states.map(|(name, count)| (vec![("status", name)], count as f64)).to_vec();
    page.family(COUNTER, "cermd_readings", "", "Readings by their state.", states);
    let faults = of.faults.iter().map(|(name, count)| (vec![("fault", &**name)], *count as f64)).collect();
    page.family(COUNTER, "cermd_faults", "", "Readings without a number.", faults);
    for (name, help, count) in [
        ("cermd_readings_moving", "Readings of a sensor that changed, among those with a number.", of.moving),
        ("cermd_cycles", "Cycles of the instrument.", of.cycles),
        ("cermd_discharges_retried", "Discharges that were tried again.", of.retried),
        ("cermd_readings_published", "Readings that were given to clients.", stats.published),
        ("cermd_lines_lost", "Lines that slow clients have lost.", stats.lost),
    ] {
        page.one(COUNTER, name, "", help, Some(count as f64));
    }
    let seconds = |ns: Option<f64>| ns.map(|ns| ns * 1e-9);
    for (name, unit, help, value) in [
        ("cermd_gpio_works", "", "Whether the GPIO lines can be used.", Some(f64::from(of.gpio_works))),
        ("cermd_clients", "", "Clients of the daemon, this bridge included.", Some(stats.clients as f64)),
        ("cermd_uptime_seconds", "seconds", "Since the daemon was started.", Some(of.uptime_s)),
        ("cermd_latency_offset_seconds", "seconds", "How late crossings are stamped.", seconds(of.offset_ns)),
        ("cermd_latency_offset_uncertainty_seconds", "seconds", "1 sigma.", seconds(of.offset_u_ns)),
        ("cermd_pin_resistance_ohms", "ohms", "Of a driven pin.", of.r_o_ohm),
        ("cermd_pin_resistance_uncertainty_ohms", "ohms", "1 sigma.", of.r_o_u_ohm),
        ("cermd_leak_resistance_ohms", "ohms", "Of a leak beside the sensors.", of.leak_ohm),
    ] {
        page.one(GAUGE, name, unit, help, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bridge::feed::Heard;
    use crate::bridge::latest::tests::{event, ok, reading, up};
    use crate::stream::wire::{EventName, InstrumentStats, VersionLine};
    use std::time::Duration;

    const AT: Nanos = Nanos(1_000);

    fn latest() -> Latest {
        let mut latest = Latest::new(Duration::from_nanos(100));
        latest.hear(&up(&["thumb", "a\\b\"c", "late"]));
        latest.hear(&reading("thumb", AT.0, StateLine { f_n: Some(4.697), ..ok(2841.3) }));
        latest.hear(&event("thumb", EventName::Pressed, None));
        latest.hear(&event("late", EventName::Released, Some("stale")));
        let fault = Some("missed-edge".to_owned());
        latest.hear(&reading("a\\b\"c", AT.0, StateLine { fault, ..StateLine::default() }));
        latest.hear(&reading("late", AT.0 - 101, ok(1.0)));
        let instrument = InstrumentStats { offset_ns: Some(8012.0), ..InstrumentStats::default() };
        let stats = StatsLine { clients: 1, published: 2, lost: 0, channels: Default::default(), instrument };
        latest.hear(&Heard::Stats(Box::new(stats), String::new()));
        latest
    }

    #[test]
    fn both_formats_say_the_same() {
        let (text, open) = (render(&latest(), AT, Format::Text), render(&latest(), AT, Format::OpenMetrics));
        insta::assert_snapshot!("openmetrics", open);
        let samples = |page: &str| {
            let lines = page.lines().filter(|line| !line.starts_with('#')).map(str::to_owned);
            lines.collect::<Vec<_>>()
        };
        assert_eq!(samples(&text), samples(&open));
        assert!(text.contains("# TYPE cermd_readings_total counter\n"), "{text}");
        assert!(open.ends_with("\n# EOF\n") && !text.contains("# EOF"));
    }

    #[test]
    fn values_have_their_unit_as_a_label() {
        let mut latest = Latest::new(Duration::from_nanos(100));
        let bath = ChannelInfo { id: "bath".to_owned(), unit: Unit::named("degC"), trigger: false };
        latest.hear(&Heard::Up(VersionLine::new(&[bath])));
        let state = StateLine { value: Some(23.5), value_u: Some(0.25), extrapolated: true, ..ok(2841.3) };
        latest.hear(&reading("bath", AT.0, state));
        let page = render(&latest, AT, Format::Text);
        for line in [
            "# TYPE cermd_value gauge",
            "cermd_value{channel=\"bath\",unit=\"degC\"} 23.5",
            "cermd_value_uncertainty{channel=\"bath\",unit=\"degC\"} 0.25",
            "cermd_reading_extrapolated{channel=\"bath\"} 1",
        ] {
            assert!(page.lines().any(|found| found == line), "{line}:\n{page}");
        }
        assert!(!page.contains("newtons") && !page.contains("bound"), "{page}");
    }

    #[test]
    fn a_resistance_has_no_law_that_it_could_be_beyond() {
        let mut latest = Latest::new(Duration::from_nanos(100));
        latest.hear(&up(&["bare"]));
        let unit = Some("ohm".to_owned());
        let state = StateLine { value: Some(2841.3), value_u: Some(1.2), unit, ..ok(2841.3) };
        latest.hear(&reading("bare", AT.0, state));
        let page = render(&latest, AT, Format::Text);
        assert!(page.contains("cermd_resistance_ohms{channel=\"bare\"} 2841.3"), "{page}");
        assert!(!page.contains("cermd_reading_extrapolated{"), "{page}");
    }

    #[test]
    fn what_is_unknown_is_absent() {
        let page = render(&latest(), AT, Format::Text);
        for absent in ["channel=\"late\"} ", "cermd_pin_resistance_ohms", "cermd_leak"] {
            assert!(!page.contains(absent), "{absent}:\n{page}");
        }
        let values = page.lines().filter(|line| !line.starts_with('#')).map(|line| line.rsplit(' ').next());
        assert!(values.map(|value| value.unwrap().parse::<f64>().unwrap()).all(f64::is_finite), "{page}");
        assert!(page.contains("cermd_channel_status{channel=\"late\",status=\"unknown\"} 1\n"), "{page}");
        let nobody = render(&Latest::new(Duration::from_secs(1)), AT, Format::Text);
        assert_eq!(nobody.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>(), ["cermd_up 0"]);
    }

    #[test]
    fn the_scraper_chooses() {
        let prometheus =
            "application/openmetrics-text;version=1.0.0;q=0.5,text/plain;version=0.0.4;q=0.3,*/*;q=0.1";
        assert_eq!(Format::of(prometheus), Format::OpenMetrics);
        for text in ["", "*/*", "text/plain", "application/openmetrics-text;q=0, text/plain"] {
            assert_eq!(Format::of(text), Format::Text, "{text}");
        }
    }
}
