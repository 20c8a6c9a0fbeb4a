//! Tables of colours: one or more grids of cells with the same rows and columns, at two widths.

use super::plot::{Width, heading};
use super::svg::{Anchor, At, LINE, Svg, width_of, wrapped};
use super::{Drawing, Figure};

/// One cell.
#[derive(Debug, Clone)]
pub struct Tile {
    /// What stands in it.
    pub text: String,
    /// What is read out for it.
    pub says: String,
    /// From 0 to 1 along the grid's colours; absent: no colour.
    pub share: Option<f64>,
    /// Why it counts as failed.
    pub failed: Option<String>,
}

/// What the colours of a grid go between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ramp {
    /// Little is dark, much is bright: cividis, which eyes of all kinds see alike.
    Amount,
    /// From too low, blue, over right to too high, red.
    Ratio,
}

/// Cells of one kind.
#[derive(Debug, Clone)]
pub struct Grid {
    pub name: String,
    pub ramp: Ramp,
    /// By row, from above, and column.
    pub cells: Vec<Vec<Option<Tile>>>,
}

/// A whole picture.
#[derive(Debug, Clone)]
pub struct Heat {
    pub title: String,
    /// What rows and columns are.
    pub axes: [String; 2],
    pub rows: Vec<String>,
    pub columns: Vec<String>,
    pub grids: Vec<Grid>,
    /// So many grids side by side, where there is room.
    pub abreast: usize,
}

impl Heat {
    /// As a figure of this name.
    pub fn figure(self, name: impl Into<String>, text: &str) -> Figure {
        Figure { name: name.into(), drawing: Drawing::Heat(self), text: text.to_owned() }
    }
}

/// One cell for each pair of a row and a column.
pub fn cells<R, C>(
    rows: &[R],
    columns: &[C],
    cell: impl Fn(&R, &C) -> Option<Tile>,
) -> Vec<Vec<Option<Tile>>> {
    rows.iter().map(|row| columns.iter().map(|column| cell(row, column)).collect()).collect()
}

type Rgb = [f64; 3];

const AMOUNT: [Rgb; 5] = [
    [0.0, 34.0, 78.0],
    [66.0, 78.0, 108.0],
    [124.0, 123.0, 120.0],
    [188.0, 175.0, 111.0],
    [254.0, 232.0, 56.0],
];
const RATIO: [Rgb; 5] = [
    [33.0, 102.0, 172.0],
    [146.0, 197.0, 222.0],
    [247.0, 247.0, 247.0],
    [244.0, 165.0, 130.0],
    [178.0, 24.0, 43.0],
];

impl Ramp {
    fn colour(self, share: f64) -> Rgb {
        let stops = if self == Ramp::Amount { AMOUNT } else { RATIO };
        let place = share.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
        let low = (place as usize).min(stops.len() - 2);
        let part = place - low as f64;
        std::array::from_fn(|index| stops[low][index] * (1.0 - part) + stops[low + 1][index] * part)
    }
}

/// Relative luminance, as contrast is defined by (WCAG 2).
fn luminance(colour: Rgb) -> f64 {
    let linear = colour.map(|part| {
        let part = part / 255.0;
        if part <= 0.040_45 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
    });
    0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
}

/// Black or white, whichever is the clearer on it.
fn ink_on(colour: Rgb) -> &'static str {
    if (luminance(colour) + 0.05) / 0.05 > 1.05 / (luminance(colour) + 0.05) { "#000" } else { "#fff" }
}

fn css([r, g, b]: Rgb) -> String {
    format!("#{:02x}{:02x}{:02x}", r.round() as u8, g.round() as u8, b.round() as u8)
}

/// Letters for reasons, in the order in which they are met.
fn reasons(grids: &[Grid]) -> Vec<String> {
    let cells = grids.iter().flat_map(|grid| grid.cells.iter().flatten().flatten());
    let mut reasons: Vec<String> = Vec::new();
    for reason in cells.filter_map(|cell| cell.failed.as_ref()) {
        if !reasons.contains(reason) {
            reasons.push(reason.clone());
        }
    }
    reasons
}

fn letter(reasons: &[String], reason: &str) -> String {
    let index = reasons.iter().position(|other| other == reason).unwrap_or(0);
    char::from_u32('A' as u32 + (index % 26) as u32).map_or(String::new(), String::from)
}

/// The height of a cell, pixels.
const CELL: f64 = 22.0;
/// Between grids side by side, pixels.
const GAP: f64 = 14.0;
/// The part of a phone's width that names of rows may take; longer ones stand above their rows.
const MARGIN: f64 = 0.3;

/// Where things stand in a drawing, pixels.
struct Layout {
    right: f64,
    abreast: usize,
    /// For names of rows, left of the first grid.
    margin: f64,
    cell: f64,
    /// From one row to the next.
    step: f64,
    /// From the left edge of a grid to that of the next.
    pitch: f64,
    reasons: Vec<String>,
}

impl Layout {
    fn new(heat: &Heat, width: Width) -> Layout {
        let right = width.px();
        let abreast = if width == Width::Wide { heat.abreast.min(heat.grids.len()).max(1) } else { 1 };
        let names = 16.0 + heat.rows.iter().map(|row| width_of(row)).fold(0.0, f64::max);
        let is_above = width == Width::Narrow && names > MARGIN * right;
        let margin = if is_above { 4.0 } else { names };
        let pitch = (right - margin) / abreast as f64;
        let cell = ((pitch - GAP) / heat.columns.len().max(1) as f64).min(120.0);
        let step = if is_above { CELL + LINE + 3.0 } else { CELL };
        Layout { right, abreast, margin, cell, step, pitch, reasons: reasons(&heat.grids) }
    }

    fn has_names_above(&self) -> bool {
        self.step > CELL
    }
}

impl Heat {
    /// The drawing and its size.
    pub fn draw(&self, width: Width) -> (Svg, At) {
        let mut svg = Svg::default();
        let layout = Layout::new(self, width);
        let mut top = heading(&mut svg, &self.title, width);
        let say = |svg: &mut Svg, class: &str, top: &mut f64, words: &str| {
            for line in wrapped(words, width.px() - 10.0) {
                svg.text(class, Anchor::Start, (2.0, *top), &line);
                *top += LINE + 1.0;
            }
        };
        top += 6.0;
        say(&mut svg, "soft", &mut top, &format!("Rows: {}. Columns: {}.", self.axes[0], self.axes[1]));
        for line in self.grids.chunks(layout.abreast) {
            for (index, grid) in line.iter().enumerate() {
                let left = layout.margin + index as f64 * layout.pitch;
                self.grid(&mut svg, grid, (left, top + 8.0), &layout, index == 0);
            }
            top +=
                layout.step * self.rows.len() as f64 + if self.is_staggered(&layout) { 80.0 } else { 62.0 };
        }
        for reason in &layout.reasons {
            say(&mut svg, "", &mut top, &format!("{} (framed): {reason}", letter(&layout.reasons, reason)));
        }
        (svg, (width.px(), top))
    }

    /// Names of columns that would touch stand on two lines in turn.
    fn is_staggered(&self, layout: &Layout) -> bool {
        self.columns.iter().any(|name| width_of(name) + 4.0 > layout.cell)
    }

    fn grid(&self, svg: &mut Svg, grid: &Grid, (left, top): At, layout: &Layout, is_first: bool) {
        svg.text("bold", Anchor::Start, (left, top + 6.0), &grid.name);
        let top = top + GAP;
        for (row, (name, cells)) in self.rows.iter().zip(&grid.cells).enumerate() {
            let y = top + layout.step * row as f64;
            if layout.has_names_above() {
                svg.text("soft", Anchor::Start, (left, y + LINE - 2.0), name);
            } else if is_first {
                svg.text("soft", Anchor::End, (left - 6.0, y + LINE), name);
            }
            for (column, found) in cells.iter().enumerate() {
                let at = (left + layout.cell * column as f64, y + layout.step - CELL);
                if let Some(found) = found {
                    draw_cell(svg, grid.ramp, found, at, layout);
                }
            }
        }
        self.columns(svg, (left, top + layout.step * self.rows.len() as f64 + GAP), layout);
    }

    fn columns(&self, svg: &mut Svg, (left, top): At, layout: &Layout) {
        let is_staggered = self.is_staggered(layout);
        // Where even two lines are not enough, some are left out.
        let widest = self.columns.iter().map(|name| width_of(name)).fold(0.0, f64::max);
        let lines = if is_staggered { 2.0 } else { 1.0 };
        let every = ((widest + 4.0) / (lines * layout.cell)).ceil().max(1.0) as usize;
        for (count, (column, name)) in self.columns.iter().enumerate().step_by(every).enumerate() {
            let half = width_of(name) / 2.0;
            let middle =
                (left + layout.cell * (column as f64 + 0.5)).min(layout.right - half).max(half + 2.0);
            let below = if is_staggered && count % 2 == 1 { LINE } else { 0.0 };
            svg.text("soft", Anchor::Middle, (middle, top + below), name);
        }
    }
}

fn draw_cell(svg: &mut Svg, ramp: Ramp, found: &Tile, at: At, layout: &Layout) {
    let colour = found.share.map(|share| ramp.colour(share));
    let fill = colour.map_or("var(--faint)".to_owned(), css);
    let ink = colour.map_or("var(--text)", ink_on);
    let sign = found.failed.as_ref().map(|reason| letter(&layout.reasons, reason));
    let (cell, middle) = (layout.cell, (at.0 + layout.cell / 2.0, at.1 + CELL / 2.0));
    svg.speaking(&found.says, middle, |svg| {
        svg.rect("cell", at, (cell, CELL), &format!("fill:{fill}"));
        let both = sign.as_ref().map(|sign| format!("{sign} {}", found.text));
        let fits = |text: &String| 0.85 * width_of(text) <= cell - 4.0;
        let words = [both, sign.clone(), Some(found.text.clone())];
        if let Some(text) = words.into_iter().flatten().find(fits) {
            svg.words_on_colour(ink, (middle.0, middle.1 + 4.0), &text);
        }
        if sign.is_some() {
            svg.rect("failed", (at.0 + 2.0, at.1 + 2.0), (cell - 4.0, CELL - 4.0), &format!("stroke:{ink}"));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heat(width: Width) -> String {
        let cell = |share, failed: Option<&str>| {
            Some(Tile {
                text: format!("{share}"),
                says: format!("cell {share}"),
                share: Some(share),
                failed: failed.map(str::to_owned),
            })
        };
        let cells =
            vec![vec![cell(0.0, None), cell(1.0, Some("leakage"))], vec![cell(0.5, Some("leakage")), None]];
        let grid = |name: &str| Grid { name: name.to_owned(), ramp: Ramp::Amount, cells: cells.clone() };
        let heat = Heat {
            title: "T".to_owned(),
            axes: ["jitter", "R"].map(str::to_owned),
            rows: vec!["1 us".to_owned(), "2 us".to_owned()],
            columns: vec!["100 ohm".to_owned(), "1 kohm".to_owned()],
            grids: vec![grid("cerm"), grid("tracked")],
            abreast: 2,
        };
        let (svg, size) = heat.draw(width);
        svg.inline(size, "T")
    }

    #[test]
    fn a_reason_has_one_letter_and_is_named_once() {
        for width in Width::BOTH {
            let text = heat(width);
            assert_eq!(text.matches("A (framed): leakage").count(), 1, "{text}");
            assert_eq!(text.matches("class=\"failed\"").count(), 4, "{text}");
            assert_eq!(text.matches("role=\"img\"").count(), 6, "{text}");
        }
    }

    #[test]
    fn words_on_every_colour_have_a_contrast_of_4_5() {
        for ramp in [Ramp::Amount, Ramp::Ratio] {
            for share in 0..=100 {
                let colour = ramp.colour(f64::from(share) / 100.0);
                let (own, ink) = (luminance(colour), if ink_on(colour) == "#000" { 0.0 } else { 1.0 });
                let contrast = (own.max(ink) + 0.05) / (own.min(ink) + 0.05);
                assert!(contrast >= 4.5, "{ramp:?} {share}: {contrast}");
            }
        }
    }
}
