//! From a table of measured points to figures and one page.
//!
//! For: `report.html`, self-contained, and each of its figures as a file, from [`Row`]s and where they come from. Must not know:
//! how points were measured, pins, the instrument.

#[doc(hidden)]
pub mod axis;
mod chooser;
mod effects;
#[cfg(test)]
mod fixture;
mod front;
mod heat;
mod limits;
mod maps;
pub mod mark;
mod page;
mod paper;
#[doc(hidden)]
pub mod plot;
mod rivals;
mod setting;
mod svg;

use crate::characterize::table::{Provenance, Row};
use crate::files::{self, FileError, TABLE_BYTES};
use page::Section;
use plot::Width;
use std::io;
use std::path::Path;

/// The name of the page in the folder of a sweep.
pub const PAGE: &str = "report.html";
/// The folder of the figures there.
pub const FIGURES: &str = "figures";

/// What is drawn.
enum Drawing {
    Plot(plot::Plot),
    Heat(heat::Heat),
}

impl Drawing {
    fn draw(&self, width: Width) -> (svg::Svg, svg::At) {
        match self {
            Drawing::Plot(plot) => plot.draw(width),
            Drawing::Heat(heat) => heat.draw(width),
        }
    }
}

/// A picture, and what is said below it.
struct Figure {
    /// Of its file, without the ending.
    name: String,
    drawing: Drawing,
    text: String,
}

const FRONT: &str = "<p>Each point is measured: the root mean square error of what is published, against the time for each published reading, charges, \
calibration, calls and readings that are lost included: those without a number, or that say of a resting sensor that it moves. Down and to the left is better. The broad line is the front: nothing measured is both faster and more accurate. \
A bar is 1 sigma of a point of few readings, if these have nothing in common. \
Hollow, dashed, in the colour and shape of a full line: the same with capacitors of other \
sizes. Thin and broken, black: what no estimator from such discharges can beat (Cram\u{e9}r-Rao), were all time spent on charges and discharges of the sensor. Grey: what one would take instead, \
computed from data sheets.</p>
<p>What \"no ADC\" buys, where an ADC is better: no converter, no bus and no driver; one GPIO line for each further sensor; a calibration that is followed by \
itself; and a stated uncertainty, or the reason why there is none, with every reading.</p>\n";
const CHOOSE: &str = "<p>Type the error that you can bear, the rate that you need, or both. Answers are measured points, nothing between.</p>\n";
const PAPER: &str = "<p>The set-up of section IV, on the scene <code>fpga-paper</code>.</p>\n";
const MAPS: &str = "<p>Colours that all eyes see alike; every cell says its numbers when it is pointed at, or by the arrow keys.</p>\n";

fn sections(rows: &[Row], board: &str, provenance: &Provenance) -> Vec<Section> {
    let mut effects: Vec<Figure> =
        [effects::budget, effects::times].into_iter().filter_map(|of| of(rows, board)).collect();
    effects.extend(effects::settling(rows, board));
    effects.extend(effects::coverage(rows, board));
    let fronts = front::figures(rows, board);
    let (rivals, chooser) = if fronts.is_empty() {
        Default::default()
    } else {
        (page::rivals(), chooser::html(rows, provenance))
    };
    let section = |id, heading, words: &str, figures, after| Section {
        id,
        heading,
        words: words.to_owned(),
        figures,
        after,
    };
    vec![
        section("front", "The front", FRONT, fronts, rivals),
        section("choose", "Choose", CHOOSE, Vec::new(), chooser),
        section("paper", "The paper's figures", PAPER, paper::figures(rows), paper::numbers::html(rows)),
        section("fails", "Where methods fail", MAPS, maps::figures(rows, board), String::new()),
        section("effects", "What an error is made of", "", effects, String::new()),
    ]
}

fn put(path: &Path, text: &str) -> Result<(), FileError> {
    files::replace(path, text).map_err(unwritten(path))
}

fn unwritten(path: &Path) -> impl Fn(io::Error) -> FileError + use<> {
    FileError::at(path, |_| "is there room, and may this user write there?")
}

/// Removes the figures of a page that is there: of what was measured then, and no other file.
fn clear(folder: &Path) {
    let page = files::read_text(&folder.join(PAGE), TABLE_BYTES).unwrap_or_default();
    let link = format!("href=\"{FIGURES}/");
    let named = page.split(&link).skip(1).filter_map(|text| text.split('"').next());
    for name in named.filter(|name| !name.contains('/')) {
        // One that stays is nobody's harm: the new page has no link to it.
        let _ = std::fs::remove_file(folder.join(FIGURES).join(name));
    }
}

/// Writes [`PAGE`] and the folder [`FIGURES`] into a folder that is there.
///
/// # Errors
/// If one of them cannot be written.
pub fn write(folder: &Path, rows: &[Row], provenance: &Provenance) -> Result<(), FileError> {
    // A picture may be met without its page.
    let board = format!("{}, {}", provenance.board, provenance.source);
    let sections = sections(rows, &board, provenance);
    clear(folder);
    let figures = folder.join(FIGURES);
    std::fs::create_dir_all(&figures).map_err(unwritten(&figures))?;
    for figure in sections.iter().flat_map(|section| &section.figures) {
        let (svg, size) = figure.drawing.draw(Width::Wide);
        put(&figures.join(format!("{}.svg", figure.name)), &svg.alone(size, &figure.text))?;
    }
    put(&folder.join(PAGE), &page::html(&sections, provenance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_has_its_page_and_every_figure_of_it_as_a_file() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &fixture::rows(), &fixture::provenance()).unwrap();
        let page = std::fs::read_to_string(folder.path().join(PAGE)).unwrap();
        let figures: Vec<_> =
            std::fs::read_dir(folder.path().join(FIGURES)).unwrap().map(|entry| entry.unwrap()).collect();
        assert!(figures.len() >= 8, "{figures:?}");
        for figure in &figures {
            let name = figure.file_name().into_string().unwrap();
            assert!(page.contains(&format!("href=\"figures/{name}\"")), "{name}");
        }
        assert!(page.contains("&lt;5 V") && !page.contains("<5 V"), "text of others is escaped");
        // Nothing is fetched: links are followed by people only.
        for fetching in [" src=\"", "@import", "url(", "fetch("] {
            assert!(!page.contains(fetching), "{fetching}");
        }
        assert!(!page.contains("NaN") && !page.contains("inf"), "a number that is none");
    }

    /// Of the paper's board; kept where `CERMD_REPORT` says, for a look in a browser (tests/browser).
    #[test]
    fn the_papers_figures_are_there_with_all_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let kept = std::env::var_os("CERMD_REPORT").map(std::path::PathBuf::from);
        let folder = kept.as_deref().unwrap_or(folder.path());
        let provenance = Provenance { board: "fpga-paper".to_owned(), ..fixture::provenance() };
        write(folder, &fixture::papers_rows(), &provenance).unwrap();
        let page = std::fs::read_to_string(folder.join(PAGE)).unwrap();
        for figure in ["4", "5a", "5b", "6a", "6b", "7", "8"] {
            assert!(page.contains(&format!("<figure id=\"paper-fig-{figure}\">")), "{figure}");
        }
        assert!(page.contains("Every number of section V") && !page.contains("not measured</td>"));
        assert!(!page.contains("NaN") && !page.contains("inf "), "a number that is none");
        assert_eq!(page.matches("(21): sqrt(3) u(T_c2A) / T_c2A").count(), 2, "at both widths");
        // A table of before there was Fig. 5(a) has the others.
        let before: Vec<Row> = fixture::papers_rows().into_iter().filter(|row| row.vary.is_none()).collect();
        assert_eq!(paper::figures(&before).len() + 1, paper::figures(&fixture::papers_rows()).len());
        // The same name, another board.
        let rows: Vec<Row> = fixture::papers_rows()
            .into_iter()
            .map(|row| Row { source: crate::characterize::table::Source::Tape, ..row })
            .collect();
        assert!(paper::figures(&rows).is_empty());
    }

    #[test]
    fn figures_of_an_earlier_choice_go_and_files_of_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &fixture::rows(), &fixture::provenance()).unwrap();
        let figures = folder.path().join(FIGURES);
        std::fs::write(figures.join("mine.svg"), "").unwrap();
        assert!(figures.join("times.svg").exists());
        write(folder.path(), &[], &fixture::provenance()).unwrap();
        let left: Vec<_> = std::fs::read_dir(figures).unwrap().map(|it| it.unwrap().file_name()).collect();
        assert_eq!(left, ["mine.svg"]);
    }

    #[test]
    fn every_command_of_a_table_is_on_its_page() {
        let folder = tempfile::tempdir().unwrap();
        let later_commands = vec!["cermctl characterize --r '<5 ohm'".to_owned()];
        let provenance = Provenance { later_commands, ..fixture::provenance() };
        write(folder.path(), &fixture::rows(), &provenance).unwrap();
        let page = std::fs::read_to_string(folder.path().join(PAGE)).unwrap();
        let both = "<code>cermctl characterize --out report</code>, then <code>cermctl characterize --r '&lt;5 ohm'</code>";
        assert!(page.contains(both), "{page}");
    }

    #[test]
    fn what_was_not_measured_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &[], &fixture::provenance()).unwrap();
        let page = std::fs::read_to_string(folder.path().join(PAGE)).unwrap();
        assert!(!page.contains("<section"), "{page}");
    }

    #[test]
    fn an_unwritable_folder_is_named() {
        let error =
            write(Path::new("/proc/no-such-folder"), &[], &fixture::provenance()).unwrap_err().to_string();
        assert!(error.starts_with("/proc/no-such-folder/figures: "), "{error}");
    }
}
