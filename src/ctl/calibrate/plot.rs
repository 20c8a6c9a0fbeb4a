//! Pairs, fit and residuals as a drawing: an SVG that is legible on white and on black.

use crate::estimate::fit::{Fit, Weighing};
use crate::sensor::Law;
use crate::units::markup::escaped;
use std::fmt::Write;

const WIDTH: f64 = 640.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 620.0;
/// Top and bottom of the upper panel, resistance over force.
const UPPER: [f64; 2] = [40.0, 300.0];
/// Of the lower one, residuals over force.
const LOWER: [f64; 2] = [340.0, 460.0];
/// Points of the curve.
const STEPS: usize = 100;

const STYLE: &str = "svg { background: #fff; color: #222; font: 13px sans-serif }
@media (prefers-color-scheme: dark) { svg { background: #111; color: #ddd } }
text { fill: currentColor } .frame { fill: none; stroke: currentColor; opacity: .5 }
.fit { fill: none; stroke: #2a8fd8; stroke-width: 2 } .pair { fill: #e0703a }";

/// A logarithmic or linear scale onto the drawing.
struct Scale {
    from: [f64; 2],
    to: [f64; 2],
}

impl Scale {
    /// That holds every value, with a margin.
    fn around(values: impl Iterator<Item = f64>, margin: f64, to: [f64; 2]) -> Scale {
        let [low, high] =
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        let margin = margin * (high - low).max(0.1);
        Scale { from: [low - margin, high + margin], to }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value - self.from[0]) / (self.from[1] - self.from[0]);
        self.to[0] + share * (self.to[1] - self.to[0])
    }
}

/// Draws at least one pair.
pub fn svg(fit: &Fit, pairs: &[Weighing], id: &str) -> String {
    let force = Scale::around(pairs.iter().map(|pair| pair.f_n.ln()), 0.08, [LEFT, RIGHT]);
    let ohm = Scale::around(pairs.iter().map(|pair| pair.r_ohm.ln()), 0.12, [UPPER[1], UPPER[0]]);
    let worst = pairs.iter().map(|&pair| fit.residual(pair).abs()).fold(1e-3, f64::max);
    let off = Scale { from: [-1.2 * worst, 1.2 * worst], to: [LOWER[1], LOWER[0]] };
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} 500\" width=\"{WIDTH}\" height=\"500\">\n\
         <style>{STYLE}</style>\n"
    );
    for [top, bottom] in [UPPER, LOWER] {
        let (width, height) = (RIGHT - LEFT, bottom - top);
        let _ = writeln!(
            out,
            "<rect class=\"frame\" x=\"{LEFT}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>"
        );
    }
    label(&mut out, LEFT, 25.0, "start", &format!("{}: resistance (ohm) over force (N)", escaped(id)));
    label(&mut out, LEFT, LOWER[0] - 10.0, "start", "residuals (% of the fit)");
    for value in ticks(force.from) {
        label(&mut out, force.at(value.ln()), LOWER[1] + 20.0, "middle", &format!("{value}"));
    }
    for value in ticks(ohm.from) {
        label(&mut out, LEFT - 8.0, ohm.at(value.ln()) + 4.0, "end", &format!("{value}"));
    }
    for value in [-worst, 0.0, worst] {
        label(&mut out, LEFT - 8.0, off.at(value) + 4.0, "end", &format!("{:+.1}", 100.0 * value));
    }
    let _ = writeln!(out, "<path class=\"frame\" d=\"M{LEFT} {0}H{RIGHT}\"/>", off.at(0.0));
    let _ = writeln!(out, "<polyline class=\"fit\" points=\"{}\"/>", curve(fit, pairs, &force, &ohm));
    for &pair in pairs {
        let x = force.at(pair.f_n.ln());
        for y in [ohm.at(pair.r_ohm.ln()), off.at(fit.residual(pair))] {
            let _ = writeln!(out, "<circle class=\"pair\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
        }
    }
    out + "</svg>\n"
}

/// The fit between the least and the greatest force; a table is straight between its pairs, as it is interpolated.
fn curve(fit: &Fit, pairs: &[Weighing], force: &Scale, ohm: &Scale) -> String {
    let mut forces: Vec<f64> = pairs.iter().map(|pair| pair.f_n).collect();
    forces.sort_by(f64::total_cmp);
    let mut points: Vec<Weighing> = match (&fit.law, forces.as_slice()) {
        (Law::Table { .. }, _) | (_, []) => pairs.to_vec(),
        (_, [low, ..]) => {
            let ratio: f64 = forces[forces.len() - 1] / low;
            let steps = (0..=STEPS).map(|step| low * ratio.powf(step as f64 / STEPS as f64));
            steps.filter_map(|f_n| Some(Weighing { f_n, r_ohm: fit.r_ohm(f_n)? })).collect()
        }
    };
    points.sort_by(|a, b| a.f_n.total_cmp(&b.f_n));
    let text = points.iter().map(|p| format!("{:.1},{:.1}", force.at(p.f_n.ln()), ohm.at(p.r_ohm.ln())));
    text.collect::<Vec<_>>().join(" ")
}

/// 1, 2 and 5 of every decade between two logarithms.
fn ticks([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    let decades = (from / 10f64.ln()).floor() as i32..=(to / 10f64.ln()).floor() as i32;
    let values = decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| format!("{digit}e{decade}")));
    // By way of the text, so that 5e-1 is shown as 0.5.
    values.filter_map(|text| text.parse::<f64>().ok()).filter(move |value| (from..=to).contains(&value.ln()))
}

fn label(out: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::fit;

    #[test]
    fn every_pair_is_inside_both_panels() {
        let pairs = [(0.3, 41_000.0), (1.2, 11_122.0), (6.06, 2200.0)];
        let pairs = pairs.map(|(f_n, r_ohm)| Weighing { f_n, r_ohm });
        for (fit, pairs) in [
            (fit::alpha(&pairs), pairs.as_slice()),
            (fit::power(&pairs), &pairs),
            (fit::table(&pairs), &pairs),
            (fit::alpha(&pairs[..1]), &pairs[..1]),
        ] {
            let text = svg(&fit.unwrap(), pairs, "a<b");
            assert!(!text.contains("NaN") && !text.contains("inf") && text.contains("a&lt;b"), "{text}");
            let number = |line: &str, key: &str| -> f64 {
                line.split(key).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
            };
            let circles: Vec<&str> = text.lines().filter(|line| line.starts_with("<circle")).collect();
            assert_eq!(circles.len(), 2 * pairs.len());
            for (index, circle) in circles.iter().enumerate() {
                let [top, bottom] = [UPPER, LOWER][index % 2];
                assert!((LEFT..=RIGHT).contains(&number(circle, "cx=\"")), "{circle}");
                assert!((top..=bottom).contains(&number(circle, "cy=\"")), "{circle}");
            }
        }
    }
}
