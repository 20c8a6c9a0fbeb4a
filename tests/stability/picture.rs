//! The first picture of the page: what is wrong with a board against how each method fares, in three colours and three signs.

use crate::scenario::Mark;
use std::fmt::Write;

/// A row of the picture.
pub struct Row {
    pub name: String,
    /// For each method, by the published equations and by ours: the worst of what was found, and in words.
    pub marks: Vec<[Option<(Mark, String)>; 2]>,
}

const NAME: usize = 480;
const TOP: usize = 58;
const ROW: usize = 21;
const COLUMN: usize = 30;
const GAP: usize = 12;
const MARGIN: usize = 10;

/// Colours that differ for the colour-blind too (Okabe and Ito), and a sign for those that see none.
const STYLE: &str = "<style>
text{font:12px sans-serif;fill:#1f2328}.head{font-weight:bold}.dim{fill:#57606a}
.holds rect{fill:#009e73}.told rect{fill:#f0e442}.fails rect{fill:#b3400a}.holds text,.fails text{fill:#fff}.told text{fill:#1f2328}
.sign{text-anchor:middle;font-weight:bold}.stripe{fill:#afb8c1;opacity:.18}
@media (prefers-color-scheme:dark){text{fill:#e6edf3}.dim{fill:#9198a1}}
</style>
";

/// How often each mark is there.
pub fn counts(groups: &[(&str, Vec<Row>)], is_ours: bool) -> [usize; 3] {
    let rows = groups.iter().flat_map(|(_, rows)| rows);
    let found: Vec<Mark> = rows
        .flat_map(|row| &row.marks)
        .filter_map(|pair| pair[usize::from(is_ours)].as_ref().map(|(mark, _)| *mark))
        .collect();
    Mark::ALL.map(|mark| found.iter().filter(|other| **other == mark).count())
}

pub fn svg(methods: &[&str], groups: &[(&str, Vec<Row>)]) -> String {
    let lines: usize = groups.iter().map(|(_, rows)| rows.len() + 1).sum();
    let (width, height) = (x(methods.len(), 0) + MARGIN, TOP + ROW * lines + MARGIN);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" role=\"img\">\n\
         <title>What is wrong with a board, and how each method fares</title>\n{STYLE}"
    );
    for (index, mark) in Mark::ALL.into_iter().enumerate() {
        let at = [MARGIN, MARGIN + 95, MARGIN + 265][index];
        cell(&mut out, at, 8, mark, mark.word());
        let says = ["it holds", "it does not, and says so", "it is wrong, and silent"][index];
        writeln!(out, "<text x=\"{}\" y=\"22\">{says}</text>", at + COLUMN + 4).unwrap();
    }
    for (index, method) in methods.iter().enumerate() {
        let middle = x(index, 0) + COLUMN;
        writeln!(out, "<text class=\"head\" text-anchor=\"middle\" x=\"{middle}\" y=\"34\">{method}</text>")
            .unwrap();
        for (column, name) in ["publ.", "ours"].into_iter().enumerate() {
            let middle = x(index, column) + COLUMN / 2 - 1;
            writeln!(out, "<text class=\"dim\" text-anchor=\"middle\" x=\"{middle}\" y=\"50\">{name}</text>")
                .unwrap();
        }
    }
    let mut y = TOP;
    for (name, rows) in groups {
        writeln!(out, "<text class=\"head\" x=\"{MARGIN}\" y=\"{}\">{name}</text>", y + 15).unwrap();
        y += ROW;
        for (index, row) in rows.iter().enumerate() {
            if index % 2 == 0 {
                let width = width - MARGIN;
                writeln!(
                    out,
                    "<rect class=\"stripe\" x=\"5\" y=\"{y}\" width=\"{width}\" height=\"{ROW}\"/>"
                )
                .unwrap();
            }
            writeln!(out, "<text x=\"{MARGIN}\" y=\"{}\">{}</text>", y + 15, escaped(&row.name)).unwrap();
            for (method, pair) in row.marks.iter().enumerate() {
                for (column, (mark, text)) in
                    pair.iter().enumerate().filter_map(|(column, of)| Some((column, of.as_ref()?)))
                {
                    cell(&mut out, x(method, column), y + 2, *mark, text);
                }
            }
            y += ROW;
        }
    }
    out + "</svg>\n"
}

fn x(method: usize, column: usize) -> usize {
    NAME + method * (2 * COLUMN + GAP) + column * COLUMN
}

fn cell(out: &mut String, x: usize, y: usize, mark: Mark, text: &str) {
    let (word, sign, width, height) = (mark.word(), mark.sign(), COLUMN - 3, ROW - 4);
    let (middle, base) = (x + width / 2, y + 13);
    let text = escaped(text);
    writeln!(
        out,
        "<g class=\"{word}\"><title>{text}</title><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"3\"/>\
         <text class=\"sign\" x=\"{middle}\" y=\"{base}\">{sign}</text></g>"
    )
    .unwrap();
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
