//! One page from figures and words: self-contained, nothing is fetched.

use super::plot::Width;
use super::rivals::RIVALS;
use super::svg::style;
use super::{Drawing, Figure};
use crate::characterize::table::{Provenance, Source};
use crate::units::markup::escaped;

const CSS: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// A part of the page.
pub struct Section {
    pub id: &'static str,
    pub heading: &'static str,
    /// HTML before the figures.
    pub words: String,
    pub figures: Vec<Figure>,
    /// HTML behind them.
    pub after: String,
}

impl Section {
    fn is_empty(&self) -> bool {
        self.figures.is_empty() && self.after.is_empty()
    }

    fn html(&self) -> String {
        let figures: String = self.figures.iter().map(figure).collect();
        let (id, heading, words, after) = (self.id, self.heading, &self.words, &self.after);
        format!(
            "<section aria-labelledby=\"{id}-heading\" id=\"{id}\">\n<h2 id=\"{id}-heading\">{heading}</h2>\n{words}\n{figures}{after}</section>\n"
        )
    }
}

fn figure(figure: &Figure) -> String {
    let drawn = |width: Width| {
        let class = if width == Width::Wide { "wide" } else { "narrow" };
        let (svg, size) = figure.drawing.draw(width);
        format!("<div class=\"{class}\">{}</div>\n", svg.inline(size, figure.drawing.title()))
    };
    let [wide, narrow] = Width::BOTH.map(drawn);
    let (text, name) = (escaped(&figure.text), &figure.name);
    format!(
        "<figure id=\"{name}\">\n{wide}{narrow}<figcaption>{text} <a href=\"figures/{name}.svg\">{name}.svg</a></figcaption></figure>\n"
    )
}

impl Drawing {
    fn title(&self) -> &str {
        match self {
            Drawing::Plot(plot) => &plot.title,
            Drawing::Heat(heat) => &heat.title,
        }
    }
}

/// What would be taken instead, with prices and sources.
pub fn rivals() -> String {
    let mut text = String::from(
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"What one would take instead\"><table><caption>What one would take instead: \
         computed from data sheets, not measured</caption><thead><tr><th scope=\"col\">what</th><th scope=\"col\">price</th><th scope=\"col\">how its numbers \
         come about</th><th scope=\"col\">sources</th></tr></thead><tbody>\n",
    );
    for rival in &RIVALS {
        let link = |(index, url): (usize, &&str)| {
            format!(
                "<a href=\"{}\" aria-label=\"{}, source {}\">[{}]</a>",
                escaped(url),
                escaped(rival.name),
                index + 1,
                index + 1
            )
        };
        let sources: Vec<String> = rival.sources.iter().enumerate().map(link).collect();
        let sources =
            if sources.is_empty() { "section V of the paper".to_owned() } else { sources.join(" ") };
        let [name, price, how] = [rival.name, rival.price, rival.how].map(escaped);
        text += &format!(
            "<tr><th scope=\"row\">{name}</th><td>{price}</td><td>{how}</td><td>{sources}</td></tr>\n"
        );
    }
    text + "</tbody></table></div>\n"
}

fn head(provenance: &Provenance) -> String {
    let [board, version, date] =
        [&provenance.board, &provenance.version, &provenance.date].map(|text| escaped(text));
    let commands: Vec<String> =
        provenance.commands().map(|command| format!("<code>{}</code>", escaped(command))).collect();
    let commands = commands.join(", then ");
    let seed = provenance.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    let badge = match provenance.source {
        Source::Simulated => "simulated",
        Source::Live => "measured on hardware",
        Source::Tape => "from a tape",
    };
    format!(
        "<header>\n<h1>Speed against accuracy: {board}</h1>\n<p><span class=\"badge\">{badge}</span> cermd {version}, {date}{seed}. The same again: {commands}</p>\n"
    )
}

/// The page; sections without anything to show are left out.
pub fn html(sections: &[Section], provenance: &Provenance) -> String {
    let shown: Vec<&Section> = sections.iter().filter(|section| !section.is_empty()).collect();
    let links: String =
        shown.iter().map(|it| format!("<li><a href=\"#{}\">{}</a></li>", it.id, it.heading)).collect();
    let body: String = shown.iter().map(|section| section.html()).collect();
    let text = provenance.text.as_ref().map_or(String::new(), |text| {
        format!("<details><summary>The scene, configuration or tape, as it was</summary><pre tabindex=\"0\">{}</pre></details>\n", escaped(text))
    });
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <title>Speed against accuracy: {}</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{}{CSS}</style>\n</head>\n<body>\n{}\
         <nav aria-label=\"Sections\"><ul>{links}</ul></nav>\n</header>\n<main>\n{body}</main>\n<footer>\n{text}\
         <p>Data: <a href=\"points.csv\">points.csv</a>, <a href=\"provenance.json\">provenance.json</a>.</p>\n</footer>\n\
         <div id=\"tip\" role=\"tooltip\" hidden></div>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        escaped(&provenance.board),
        style(),
        head(provenance),
    )
}
