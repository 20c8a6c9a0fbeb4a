//! Shapes and words as SVG, in CSS pixels; colours and strokes are classes of `figure.css`.

use crate::units::markup::escaped;
use std::fmt::Write;

/// What all figures look like, in light and dark and on paper.
const STYLE: &str = include_str!("figure.css");
/// The height of a line of words.
pub const LINE: f64 = 15.0;

/// A point of the drawing: right and down.
pub type At = (f64, f64);

/// On which side of its place a text stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing that is being written.
#[derive(Debug, Default)]
pub struct Svg {
    body: Vec<Piece>,
}

#[derive(Debug)]
enum Piece {
    Markup(String),
    /// The beginning of a group that says something.
    Speaking {
        says: String,
        at: At,
    },
}

/// How a number is written in a drawing: to a tenth of a pixel.
fn px(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

/// About how wide a text of the size of labels is, pixels.
pub fn width_of(text: &str) -> f64 {
    7.3 * text.chars().count() as f64
}

/// Lines of words that are at most so wide, pixels.
pub fn wrapped(text: &str, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].is_empty() {
            lines[last] += word;
        } else if width_of(&lines[last]) + width_of(word) + 6.0 <= width {
            lines[last] += " ";
            lines[last] += word;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

impl Svg {
    pub fn line(&mut self, class: &str, from: At, to: At) {
        let [x1, y1, x2, y2] = [from.0, from.1, to.0, to.1].map(px);
        self.raw(&format!(r#"<path class="{class}" d="M{x1} {y1}L{x2} {y2}"/>"#));
    }

    /// Straight from one point to the next.
    pub fn polyline(&mut self, class: &str, points: &[At]) {
        let mut path = String::new();
        for (index, (x, y)) in points.iter().enumerate() {
            let command = if index == 0 { 'M' } else { 'L' };
            path += &format!("{command}{} {}", px(*x), px(*y));
        }
        self.raw(&format!(r#"<path class="{class}" d="{path}"/>"#));
    }

    pub fn text(&mut self, class: &str, anchor: Anchor, (x, y): At, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y, text) = (px(x), px(y), escaped(text));
        self.raw(&format!(r#"<text class="{class}" x="{x}" y="{y}" text-anchor="{anchor}">{text}</text>"#));
    }

    /// Small, in the middle, in a colour that goes with what is below.
    pub fn words_on_colour(&mut self, ink: &str, (x, y): At, text: &str) {
        let (x, y, text) = (px(x), px(y), escaped(text.trim()));
        let place = format!(r#"style="fill:{ink}" x="{x}" y="{y}" text-anchor="middle""#);
        self.raw(&format!(r#"<text class="small" {place}>{text}</text>"#));
    }

    /// `style` is for what no class can know, such as a colour that stands for a number.
    pub fn rect(&mut self, class: &str, (x, y): At, (width, height): At, style: &str) {
        let [x, y, width, height] = [x, y, width, height].map(px);
        let style = if style.is_empty() { String::new() } else { format!(r#" style="{style}""#) };
        let place = format!(r#"x="{x}" y="{y}" width="{width}" height="{height}""#);
        self.raw(&format!(r#"<rect class="{class}" {place}{style}/>"#));
    }

    /// A group of its own that can be pointed at and read out, with what it says.
    pub fn speaking(&mut self, says: &str, (x, y): At, draw: impl FnOnce(&mut Svg)) {
        self.body.push(Piece::Speaking { says: escaped(says), at: (px(x), px(y)) });
        draw(self);
        self.raw("</g>");
    }

    /// What is drawn inside is cut off at the edges.
    pub fn cut(&mut self, (x, y): At, (width, height): At, draw: impl FnOnce(&mut Svg)) {
        let [x, y, width, height] = [x, y, width, height].map(px);
        let place = format!(r#"x="{x}" y="{y}" width="{width}" height="{height}""#);
        self.raw(&format!(r#"<svg {place} viewBox="{x} {y} {width} {height}">"#));
        draw(self);
        self.raw("</svg>");
    }

    pub fn raw(&mut self, markup: &str) {
        self.body.push(Piece::Markup(markup.to_owned()));
    }

    /// All of it; `names` says how a group says what it says.
    fn markup(&self, names: fn(&str) -> String) -> String {
        let mut body = String::new();
        for piece in &self.body {
            let _ = match piece {
                Piece::Markup(markup) => writeln!(body, "{markup}"),
                Piece::Speaking { says, at: (x, y) } => {
                    writeln!(body, r#"<g class="point" role="img" data-x="{x}" data-y="{y}"{}"#, names(says))
                }
            };
        }
        body
    }

    /// For a page that has [`STYLE`]. There a point has a label, since its title would show twice, by the browser and by the page.
    pub fn inline(&self, (width, height): At, title: &str) -> String {
        let body = self.markup(|says| format!(r#" aria-label="{says}">"#));
        let (title, size) = (escaped(title), format!(r#"viewBox="0 0 {} {}""#, px(width), px(height)));
        format!("<svg class=\"figure\" role=\"group\" aria-label=\"{title}\" {size}>\n{body}</svg>\n")
    }

    /// A file of its own.
    pub fn alone(&self, (width, height): At, title: &str) -> String {
        let ((width, height), title) = ((px(width), px(height)), escaped(title));
        let size = format!(r#"width="{width}" height="{height}" viewBox="0 0 {width} {height}""#);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"figure\" role=\"group\" aria-label=\"{title}\" {size}>\n\
             <style>{STYLE}</style>\n<rect class=\"page\" width=\"{width}\" height=\"{height}\"/>\n{}</svg>\n",
            self.markup(|says| format!("><title>{says}</title>"))
        )
    }
}

/// See [`STYLE`].
pub fn style() -> &'static str {
    STYLE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_others_stay_words() {
        let mut svg = Svg::default();
        svg.text("label", Anchor::End, (1.04, 2.0), "a < b & \"c\"");
        svg.speaking("1 < 2", (0.0, 0.0), |svg| svg.line("axis", (0.0, 0.0), (1.0, 1.0)));
        let alone = svg.alone((10.0, 20.0), "<x>");
        assert!(
            alone.contains(r#"x="1" y="2" text-anchor="end">a &lt; b &amp; &quot;c&quot;</text>"#),
            "{alone}"
        );
        assert!(alone.contains("<title>1 &lt; 2</title>") && alone.contains("aria-label=\"&lt;x&gt;\""));
        let inline = svg.inline((10.0, 20.0), "t");
        assert!(!inline.contains("<title>") && inline.contains("aria-label=\"1 &lt; 2\""), "{inline}");
    }

    #[test]
    fn words_are_wrapped_and_none_is_lost() {
        let lines = wrapped("one two three four", width_of("two three"));
        assert_eq!(lines, ["one two", "three", "four"]);
        assert_eq!(wrapped("unbreakable", 1.0), ["unbreakable"]);
    }
}
