//! What tells series of a plot apart: shapes, their insides, colours.

use super::svg::{At, Svg};
use std::fmt;

/// The shape of a point, so that colours are not all that tells series apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    Circle,
    Square,
    Triangle,
    Diamond,
    Cross,
    Plus,
    /// Beyond the left edge.
    Left,
}

impl Mark {
    pub const ROUND: [Mark; 6] =
        [Mark::Circle, Mark::Square, Mark::Triangle, Mark::Diamond, Mark::Cross, Mark::Plus];

    fn path(self, (x, y): At) -> String {
        let [x, y] = [x, y].map(|value| (value * 10.0).round() / 10.0);
        match self {
            Mark::Circle => format!("M{} {y}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z", x - 4.0),
            Mark::Square => format!("M{} {}h7v7h-7z", x - 3.5, y - 3.5),
            Mark::Triangle => format!("M{x} {}l5 8h-10z", y - 5.0),
            Mark::Diamond => format!("M{x} {}l5 5l-5 5l-5 -5z", y - 5.0),
            Mark::Cross => format!("M{} {}l8 8m0 -8l-8 8", x - 4.0, y - 4.0),
            Mark::Plus => format!("M{} {y}h10m-5 -5v10", x - 5.0),
            Mark::Left => format!("M{} {y}l9 -5v10z", x - 1.0),
        }
    }

    pub(super) fn draw(self, svg: &mut Svg, (ink, filling): (Ink, Filling), at: At) {
        svg.raw(&format!(r#"<path class="mark ink {ink} {filling}" d="{}"/>"#, self.path(at)));
    }
}

/// The number of a colour in `figure.css`; shown as its class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ink(pub usize);

impl Ink {
    // Those before are the methods'.
    pub const RIVAL: Ink = Ink(5);
    pub const NEUTRAL: Ink = Ink(6);
    pub const BEST: Ink = Ink(7);
}

impl fmt::Display for Ink {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "i{}", self.0)
    }
}

/// The inside of a mark; shown as its class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filling {
    Full,
    Hollow,
}

impl fmt::Display for Filling {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(if *self == Filling::Full { "full" } else { "hollow" })
    }
}
