//! Lines and points over two axes, labelled where they end, at two widths.

use super::axis::Axis;
use super::mark::{Filling, Ink, Mark};
use super::svg::{Anchor, At, LINE, Svg, width_of, wrapped};

/// How wide a drawing may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    /// Of a page or a screen.
    Wide,
    /// Of a phone: names stand below, letters at the lines.
    Narrow,
}

impl Width {
    pub const BOTH: [Width; 2] = [Width::Wide, Width::Narrow];

    /// Pixels.
    pub fn px(self) -> f64 {
        if self == Width::Wide { 920.0 } else { 358.0 }
    }
}

/// One value over another.
#[derive(Debug, Clone)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    /// 1 sigma of y, as a part of it: a bar, where it is worth one.
    pub scatter: Option<f64>,
    /// What is read out for it.
    pub says: String,
}

impl Point {
    pub fn new(x: f64, y: f64, says: String) -> Point {
        Point { x, y, scatter: None, says }
    }
}

/// What belongs together.
#[derive(Debug, Clone)]
pub struct Series {
    /// At its end, or in the list below; empty: without a label.
    pub name: String,
    pub ink: Ink,
    /// Classes of `figure.css`.
    pub stroke: Option<&'static str>,
    pub mark: Option<(Mark, Filling)>,
    pub points: Vec<Point>,
    /// From a point level to the next one's x, then to it.
    pub is_stairs: bool,
}

/// A whole picture.
#[derive(Debug, Clone)]
pub struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// Those that come first lie below.
    pub series: Vec<Series>,
}

/// What words at ticks take along x and along y, pixels.
const TICKS: At = (68.0, 30.0);

/// Where things stand in a drawing.
struct Frame<'a> {
    plot: &'a Plot,
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

/// Places of labels along a line so that none covers another, near where they would be, in the same order.
fn spread(wanted: &[f64], step: f64, from: f64, to: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let mut places = vec![0.0; wanted.len()];
    let mut least = from;
    for index in &order {
        places[*index] = wanted[*index].max(least);
        least = places[*index] + step;
    }
    let mut most = to;
    for index in order.iter().rev() {
        places[*index] = places[*index].min(most);
        most = places[*index] - step;
    }
    places
}

/// The sign of a series where there is no room for its name.
fn letter(index: usize) -> String {
    char::from_u32('a' as u32 + (index % 26) as u32).map_or(String::new(), String::from)
}

impl Frame<'_> {
    fn at(&self, x: f64, y: f64) -> At {
        let (x, y) = (self.plot.x.share(x), self.plot.y.share(y));
        (self.left + self.width * x, self.top + self.height * (1.0 - y))
    }

    fn axes(&self, svg: &mut Svg, width: Width) {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        let room = [(self.width / TICKS.0) as usize, (self.height / TICKS.1) as usize];
        let (x_ticks, x_lines) = self.plot.x.ticks(room[0]);
        let (y_ticks, y_lines) = self.plot.y.ticks(room[1]);
        for (values, class) in [(&x_lines, "faint"), (&x_ticks, "grid")] {
            for value in values {
                let x = self.at(*value, self.plot.y.from).0;
                svg.line(class, (x, self.top), (x, bottom));
            }
        }
        for (values, class) in [(&y_lines, "faint"), (&y_ticks, "grid")] {
            for value in values {
                let y = self.at(self.plot.x.from, *value).1;
                svg.line(class, (self.left, y), (right, y));
            }
        }
        for value in &x_ticks {
            let x = self.at(*value, self.plot.y.from).0;
            svg.text("soft", Anchor::Middle, (x, bottom + 17.0), &(self.plot.x.write)(*value));
        }
        for value in &y_ticks {
            let y = self.at(self.plot.x.from, *value).1;
            svg.text("soft", Anchor::End, (self.left - 7.0, y + 4.0), &(self.plot.y.write)(*value));
        }
        svg.polyline("axis", &[(self.left, self.top), (self.left, bottom), (right, bottom)]);
        svg.text(
            "",
            Anchor::Start,
            (if width == Width::Wide { self.left } else { 2.0 }, self.top - 9.0),
            &self.plot.y.label,
        );
        svg.text("", Anchor::End, (right, bottom + 35.0), &self.plot.x.label);
    }

    fn series(&self, svg: &mut Svg, series: &Series) {
        let mut path: Vec<At> = Vec::new();
        for point in &series.points {
            let (x, y) = self.at(point.x, point.y);
            if let (true, Some((_, last))) = (series.is_stairs, path.last().copied()) {
                path.push((x, last));
            }
            path.push((x, y));
        }
        if let Some(stroke) = series.stroke {
            let (from, size) = ((self.left, self.top), (self.width, self.height));
            svg.cut(from, size, |svg| svg.polyline(&format!("ink {} {stroke}", series.ink), &path));
        }
        let Some((mark, filling)) = series.mark else { return };
        for point in series.points.iter().filter(|point| self.plot.y.contains(point.y)) {
            let is_left = point.x < self.plot.x.from;
            if is_left || self.plot.x.contains(point.x) {
                let mark = if is_left { Mark::Left } else { mark };
                let at = self.at(point.x.max(self.plot.x.from), point.y);
                svg.speaking(&point.says, at, |svg| {
                    if let Some(scatter) = point.scatter {
                        let ends =
                            [1.0 - scatter, 1.0 + scatter].map(|part| self.at(point.x, point.y * part));
                        svg.line(&format!("ink thin {} {filling}", series.ink), ends[0], ends[1]);
                    }
                    mark.draw(svg, (series.ink, filling), at);
                });
            }
        }
    }

    /// Names at the last points that can be seen: in the margin, or beside those that are far from it and from each other.
    fn labels(&self, svg: &mut Svg, width: Width) {
        let name = |(index, series): (usize, &Series)| {
            let name = if width == Width::Wide { series.name.clone() } else { letter(index) };
            (name, self.end_of(series))
        };
        let names: Vec<(String, At)> = self.plot.named().enumerate().map(name).collect();
        let is_far = |end: At| end.0 <= self.left + 0.5 * self.width;
        let covers = |(name, end): &(String, At), (other, at): &(String, At)| {
            let is_left = end.0 + width_of(name) < at.0 || at.0 + width_of(other) < end.0;
            is_far(*at) && !is_left && (end.1 - at.1).abs() < LINE
        };
        let is_beside = |index: usize| {
            let others = names.iter().enumerate().filter(|(other, _)| *other != index);
            is_far(names[index].1)
                && !others.map(|(_, other)| other).any(|other| covers(&names[index], other))
        };
        let in_margin = (0..names.len()).filter(|index| !is_beside(*index));
        let wanted: Vec<f64> = in_margin.map(|index| names[index].1.1).collect();
        let places = spread(&wanted, LINE, self.top + 4.0, self.top + self.height - 2.0);
        let mut places = places.into_iter().peekable();
        for (index, series) in self.plot.named().enumerate() {
            let x = self.left + self.width + if width == Width::Wide { 26.0 } else { 12.0 };
            let (name, end) = &names[index];
            let class = format!("bold coloured {}", series.ink);
            if let Some(place) = places.next_if(|_| !is_beside(index)) {
                svg.line("lead", (end.0 + 6.0, end.1), (x - 4.0, place));
                svg.text(&class, Anchor::Start, (x, place + 4.0), name);
            } else {
                svg.text(&format!("{class} halo"), Anchor::Start, (end.0 + 9.0, end.1 - 5.0), name);
            }
        }
    }

    fn end_of(&self, series: &Series) -> At {
        let seen = |point: &&Point| self.plot.x.share(point.x) <= 1.01 && self.plot.y.contains(point.y);
        let last = series.points.iter().rev().find(seen).or(series.points.last());
        last.map_or((self.left, self.top), |point| {
            let (x, y) = self.at(point.x.max(self.plot.x.from), point.y);
            (x.min(self.left + self.width), y.clamp(self.top, self.top + self.height))
        })
    }
}

/// A title, in as many lines as it takes; how high they are, pixels.
pub(super) fn heading(svg: &mut Svg, title: &str, width: Width) -> f64 {
    // Letters of a heading are a third larger.
    let lines = wrapped(title, width.px() / 1.33);
    for (index, line) in lines.iter().enumerate() {
        svg.text("heading", Anchor::Start, (2.0, 18.0 + 19.0 * index as f64), line);
    }
    10.0 + 19.0 * lines.len() as f64
}

impl Plot {
    fn named(&self) -> impl Iterator<Item = &Series> + Clone {
        self.series.iter().filter(|series| !series.name.is_empty())
    }

    /// A file of its own.
    pub fn alone(&self) -> String {
        let (svg, size) = self.draw(Width::Wide);
        svg.alone(size, &self.title)
    }

    /// The drawing and its size.
    pub(super) fn draw(&self, width: Width) -> (Svg, At) {
        let mut svg = Svg::default();
        let top = heading(&mut svg, &self.title, width) + 24.0;
        let widest = self.named().map(|series| width_of(&series.name)).fold(0.0, f64::max);
        let (right, height): (f64, f64) = match width {
            Width::Wide => (34.0 + widest, 400.0),
            Width::Narrow => (26.0, 330.0),
        };
        let height = height.max(LINE * self.named().count() as f64 + 10.0);
        let ticks = self.y.ticks((height / TICKS.1) as usize).0;
        let left = 14.0 + ticks.iter().map(|tick| width_of(&(self.y.write)(*tick))).fold(0.0, f64::max);
        let frame = Frame { plot: self, left, top, width: width.px() - left - right, height };
        frame.axes(&mut svg, width);
        self.series.iter().for_each(|series| frame.series(&mut svg, series));
        frame.labels(&mut svg, width);
        let bottom = top + height + 44.0;
        let bottom = if width == Width::Narrow { self.list(&mut svg, bottom, width) } else { bottom };
        (svg, (width.px(), bottom + 4.0))
    }

    /// What the letters stand for; where the list ends.
    fn list(&self, svg: &mut Svg, mut top: f64, width: Width) -> f64 {
        for (index, series) in self.named().enumerate() {
            let class = format!("bold coloured {}", series.ink);
            svg.text(&class, Anchor::Start, (4.0, top + 12.0), &letter(index));
            match (series.mark, series.stroke) {
                (Some((mark, filling)), _) => mark.draw(svg, (series.ink, filling), (24.0, top + 8.0)),
                (None, stroke) => {
                    let class = format!("ink {} {}", series.ink, stroke.unwrap_or_default());
                    svg.line(&class, (16.0, top + 8.0), (32.0, top + 8.0));
                }
            }
            for line in wrapped(&series.name, width.px() - 40.0) {
                svg.text("", Anchor::Start, (36.0, top + 12.0), &line);
                top += LINE + 2.0;
            }
        }
        top
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis::{ohms, seconds};
    use super::*;

    fn plot(names: &[&str]) -> Plot {
        let points = [(0.0001, 1.0), (0.01, 0.5), (100.0, 0.1)];
        let point = |(x, y)| Point::new(x, y, format!("{y} in {x}"));
        let series = names.iter().map(|name| Series {
            name: (*name).to_owned(),
            ink: Ink(2),
            stroke: Some("series"),
            mark: Some((Mark::Circle, Filling::Full)),
            points: points.map(point).to_vec(),
            is_stairs: true,
        });
        Plot {
            title: "A title that takes more than one line on a phone".to_owned(),
            x: Axis::decades("time", seconds, [0.001, 10.0].into_iter()).unwrap(),
            y: Axis::decades("error", ohms, [0.01, 1.0].into_iter()).unwrap(),
            series: series.collect(),
        }
    }

    #[test]
    fn labels_keep_apart_in_their_order() {
        let places = spread(&[100.0, 10.0, 101.0, 99.0, 398.0, 399.0], 15.0, 4.0, 400.0);
        let mut sorted = places.clone();
        sorted.sort_by(f64::total_cmp);
        assert!(sorted.windows(2).all(|pair| pair[1] - pair[0] >= 15.0 - 1e-9), "{places:?}");
        assert!(places[1] < places[3] && places[3] < places[0] && places[0] < places[2], "{places:?}");
        assert!(sorted[0] >= 4.0 && sorted[5] <= 400.0, "{places:?}");
    }

    #[test]
    fn names_of_points_at_one_place_stand_in_the_margin_each_on_its_line() {
        let mut plot = plot(&["one", "other"]);
        plot.series.iter_mut().for_each(|series| series.points.truncate(2));
        let names = |plot: &Plot| plot.alone().matches("class=\"lead\"").count();
        assert_eq!(names(&plot), 2);
        plot.series.truncate(1);
        assert_eq!(names(&plot), 0, "there is room beside it");
    }

    #[test]
    fn what_is_too_fast_for_the_axis_stands_at_its_edge_and_what_is_too_slow_is_left_out() {
        let (svg, size) = plot(&["it"]).draw(Width::Wide);
        let text = svg.alone(size, "t");
        assert!(text.contains("1 in 0.0001") && text.contains("0.5 in 0.01"), "{text}");
        assert!(!text.contains("in 100<"), "{text}");
    }

    #[test]
    fn a_phone_gets_letters_and_a_list_and_nothing_is_wider() {
        let (svg, size) = plot(&["first of all", "second"]).draw(Width::Narrow);
        let text = svg.inline(size, "t");
        assert!(text.contains(">a</text>") && text.contains(">first of all</text>"), "{text}");
        assert_eq!(size.0, 358.0);
        assert_eq!(text.matches("class=\"heading\"").count(), 2);
    }
}
