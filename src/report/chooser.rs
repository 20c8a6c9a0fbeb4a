//! The chooser: which setting gives the error that can be borne, or the rate that is needed; a form, its data, no answer of its own.

use super::front::priced;
use super::setting::Setting;
use crate::characterize::table::{Provenance, Row};
use crate::units::rounded;
use serde::Serialize;

/// One measured row, as the script of the page reads it; absent: unknown.
#[derive(Debug, Serialize)]
struct ChooserRow {
    name: String,
    method: &'static str,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    average_s: Option<f64>,
    /// Times the capacitors of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<f64>,
    r_ohm: f64,
    seconds: f64,
    error_ohm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    u_ohm: Option<f64>,
    /// The share of readings that its errors are not of.
    #[serde(skip_serializing_if = "Option::is_none")]
    lost: Option<f64>,
}

const FORM: &str = r#"<form id="chooser">
<p><label for="want-r">Resistance</label> <select id="want-r"></select></p>
<p><label for="want-error">Error that can be borne, 1 sigma, ohm</label> <input id="want-error" inputmode="decimal" autocomplete="off" size="8"></p>
<p><label for="want-rate">Readings a second that are needed</label> <input id="want-rate" inputmode="decimal" autocomplete="off" size="8"></p>
</form>
<p id="chosen" role="status"></p>
<noscript><p>The chooser needs scripts; the figures above and points.csv have the same numbers.</p></noscript>
"#;

/// The form with its data, and whether an answer is measured again by `cermctl characterize --scene`.
pub fn html(rows: &[Row], provenance: &Provenance) -> String {
    let priced = priced(rows);
    let settings = Setting::all(priced.iter().map(|priced| Setting::of(priced.row)));
    let choice = |setting: Setting, priced: &super::front::Priced| ChooserRow {
        name: setting.name(&settings),
        method: setting.method.as_str(),
        kind: setting.kind.as_str(),
        average_s: priced.row.average_s,
        size: priced.row.vary_value,
        r_ohm: priced.row.r_ohm,
        seconds: priced.seconds,
        error_ohm: priced.error,
        u_ohm: priced.row.u_ohm,
        lost: Some(rounded(1.0 - priced.row.counted(), 3)).filter(|share| *share > 0.0),
    };
    let choices: Vec<ChooserRow> =
        priced.iter().map(|priced| choice(Setting::of(priced.row), priced)).collect();
    // It has no map whose keys are no text, which is all that can go wrong. Nothing in it may end the element that it stands in.
    let data = serde_json::to_string(&choices).unwrap_or_default().replace("</", "<\\/");
    let again = if provenance.is_of_a_scene_alone() { " data-again" } else { "" };
    format!("{FORM}<script type=\"application/json\" id=\"choices\"{again}>{data}</script>\n")
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;
    use crate::characterize::table::Source;

    #[test]
    fn every_measured_point_can_be_chosen() {
        let rows = fixture::rows();
        let html = html(&rows, &fixture::provenance());
        let data =
            html.split("id=\"choices\" data-again>").nth(1).unwrap().split("</script>").next().unwrap();
        let choices: Vec<serde_json::Value> = serde_json::from_str(data).unwrap();
        assert_eq!(choices.len(), priced(&rows).len());
        assert_eq!(choices[0]["method"], "tpcm");
        assert!(choices[0].get("average_s").is_none(), "absent means unknown or none, never null");
    }

    #[test]
    fn what_a_scene_alone_does_not_make_again_is_not_said_to_be() {
        let again = |provenance: Provenance| html(&fixture::rows(), &provenance).contains("data-again");
        let by = |words: &str| Provenance {
            command: format!("cermctl characterize {words}"),
            ..fixture::provenance()
        };
        assert!(again(by("--scene pi4 --out --configured")));
        assert!(!again(by("--config a.toml --out b")) && !again(by("--config=a.toml --out b")));
        assert!(!again(Provenance { source: Source::Live, ..fixture::provenance() }));
    }
}
