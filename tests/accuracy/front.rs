//! `docs/speed-and-accuracy.md` and its pictures, from the table in `docs/speed-and-accuracy`, and whether that table is what is
//! measured.
//!
//! `cermctl characterize --scene pi4 --out docs/speed-and-accuracy` measures it anew where it is not; then
//! `UPDATE_DOCS=1 cargo test --test accuracy front` writes page and pictures.

use crate::common::check_page;
use crate::common::seed::family;
use cermd::characterize::cell::Cell;
use cermd::characterize::sweep::Sweep;
use cermd::characterize::table::{POINTS, PROVENANCE, Provenance, Row, Vary, read};
use cermd::pins::sim::Scene;
use cermd::report;
use cermd::units::{Seconds, rounded};
use std::fmt::Write;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/speed-and-accuracy");
/// Pictures of the report that pages show: their names there and here.
const PICTURES: [(&str, &str); 5] = [
    ("front-1000-ohm", "front.svg"),
    ("front-16200-ohm", "speed-and-accuracy/front-16200-ohm.svg"),
    ("map-jitter", "map-jitter.svg"),
    ("map-capacitor", "map-capacitor.svg"),
    ("map-speed", "map-speed.svg"),
];

const HEAD: &str = "# Speed against accuracy

Each point is a setting that was measured: the root mean square error of what is published (1 sigma), against the time for each
published reading, charges, calibration, looks for a leak, calls and lost readings included. Every figure of ours is **simulated**,
in virtual time, on the board `pi4` ([hw/scenes/pi4.toml](../hw/scenes/pi4.toml)); what one would take instead is computed from data
sheets.

![Error against time per published reading at 1 kohm, with bounds and what one would take instead](front.svg)

![The same at 16.2 kohm](speed-and-accuracy/front-16200-ohm.svg)

## The front in numbers

What nothing beats that is both faster and more accurate:

| R_x / ohm | error / ohm | time for each reading | setting | u / ohm | within 2u |
|--:|--:|--:|---|--:|--:|
";

const TAIL: &str = "
## Make it again, or for your board

```sh
cermctl characterize --scene pi4 --out report     # half a minute on four processors; Ctrl-C, and the same command goes on
cermctl characterize --config /etc/cermd/cermd.toml --out report    # on hardware: asks for one known resistor after another
cermctl characterize --tape recorded.tape --truth thumb=997.3 --out report
```

`report/report.html` has these figures, the settings to choose from, the paper's figures, maps of where methods fail, and what errors are
made of; `report/points.csv` is the table, a row for each point ([the one of this page](speed-and-accuracy/points.csv)), and
`report/provenance.json` says where it comes from. Errors are in ohm, times in seconds; what is not known is empty.

| column | what it is |
|---|---|
| `source`, `scene`, `seed` | `simulated`, `live` or `tape`; of what; of the first instrument |
| `circuit`, `c_a_f`, `c_b_f`, `r_c1_ohm`, `r_c2_ohm` | the wiring and its parts |
| `method`, `average_s` | how it is read; what is published is the mean over so long, empty: each reading |
| `vary`, `vary_value`, `vary_name` | what is other than the scene says (`jitter`, `offset-error`: s; `capacitor`: times; `leakage`: ohm; `speed`: 1/s; `without`: an effect; `since-start`: s; `switch-fraction`: CERM infers at all resistances, the switch at this part of T_xA) |
| `r_ohm`, `instruments`, `readings` | the truth; how many instruments, and published readings of all of them |
| `no_number`, `reason`, `settling`, `moving` | the share of readings without a number and the most frequent reason; of those whose u is a prior; of those that say that the sensor moves |
| `bias_ohm`, `sd_ohm`, `rms_ohm` | mean error, standard deviation, root mean square error |
| `mae_ohm`, `mre_percent` | eq. (28) and (29) of the paper: the largest error of an instrument, the mean over instruments |
| `u_ohm`, `coverage` | what is stated of the error, 1 sigma; the share of errors below twice that |
| `published_s` | time for each published reading: the sum of `charge_s`, `discharge_s`, `calibration_s` and `overhead_s` |
| `bound_ohm` | the Cramer-Rao bound of the discharges that were taken, calibration known exactly |
| `t_ixa_rsd`, `t_ixb_rsd`, `t_c2a_rsd` | with a `switch-fraction` only: relative standard deviations of the times that eq. (16) and (18) infer, and of T_c2A (Fig. 5(a) of the paper) |

To plot it with Python (`pip install matplotlib`):

```python
import csv
import matplotlib.pyplot as plt

lines = {}
for row in csv.DictReader(open(\"report/points.csv\")):
    if row[\"r_ohm\"] == \"1000.0\" and not row[\"vary\"] and row[\"rms_ohm\"]:
        name = row[\"method\"] + \", \" + row[\"circuit\"]
        lines.setdefault(name, []).append((float(row[\"published_s\"]), float(row[\"rms_ohm\"])))
for name, points in lines.items():
    plt.loglog(*zip(*sorted(points)), marker=\"o\", label=name)
plt.xlabel(\"time for each published reading / s\")
plt.ylabel(\"error / ohm\")
plt.legend()
plt.savefig(\"front.png\")
```
";

fn text(name: &str) -> String {
    let path = format!("{FOLDER}/{name}");
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn table() -> (Vec<Row>, Provenance) {
    (read(&text(POINTS)).unwrap(), serde_json::from_str(&text(PROVENANCE)).unwrap())
}

/// Rows of a resistance that no other one beats in error and time.
fn front(rows: &[Row], r_ohm: f64) -> Vec<&Row> {
    let is_known = |row: &&Row| row.vary.is_none() && row.rms_ohm.is_some() && row.counted() > 0.5;
    let mut known: Vec<&Row> = rows.iter().filter(|row| row.r_ohm == r_ohm).filter(is_known).collect();
    // Equal means take equal times, but for when their last reading comes.
    let price = |row: &Row| [rounded(row.counted_s().unwrap(), 2), row.rms_ohm.unwrap()];
    known.sort_by(|a, b| price(a).partial_cmp(&price(b)).unwrap());
    let mut best = f64::INFINITY;
    known.retain(|row| {
        let is_better = row.rms_ohm < Some(best);
        best = row.rms_ohm.unwrap().min(best);
        is_better
    });
    known
}

fn setting(row: &Row) -> String {
    let mean = row.average_s.map_or("each reading".to_owned(), |s| format!("mean over {}", Seconds(s)));
    format!("`{}`, {}, {mean}", row.method, row.circuit)
}

#[test]
fn the_page_and_its_pictures_are_those_of_the_table() {
    let (rows, provenance) = table();
    let mut page = HEAD.to_owned();
    for r_ohm in [100.0, 1000.0, 5000.0, 16_200.0] {
        for row in front(&rows, r_ohm) {
            let figure = |value: Option<f64>| rounded(value.unwrap(), 2);
            let (error, u) = (figure(row.rms_ohm), figure(row.u_ohm));
            let (time, within) = (Seconds(row.counted_s().unwrap()), 100.0 * row.coverage.unwrap());
            writeln!(page, "| {r_ohm} | {error} | {time:.2} | {} | {u} | {within:.0} % |", setting(row))
                .unwrap();
        }
    }
    check_page("accuracy front", "speed-and-accuracy.md", &(page + TAIL));
    let folder = tempfile::tempdir().unwrap();
    report::write(folder.path(), &rows, &provenance).unwrap();
    for (figure, picture) in PICTURES {
        let drawn = folder.path().join(report::FIGURES).join(format!("{figure}.svg"));
        check_page("accuracy front", picture, &std::fs::read_to_string(drawn).unwrap());
    }
}

/// A few of its cells measured again: the table in docs is of this instrument, and of no other.
#[test]
fn the_table_is_what_is_measured() {
    if family() != 0 {
        return;
    }
    let (rows, provenance) = table();
    let scene = Scene::builtin("pi4").unwrap();
    let text = Scene::text_of("pi4", "".as_ref()).unwrap();
    assert_eq!(
        (provenance.board.as_str(), provenance.text),
        ("pi4", Some(text)),
        "hw/scenes/pi4.toml is another"
    );
    let sweep = Sweep {
        name: "pi4".to_owned(),
        seed: provenance.seed.unwrap(),
        scene,
        config: None,
        methods: Vec::new(),
        kinds: Vec::new(),
        r_ohm: Vec::new(),
        averages: Vec::new(),
        instruments: None,
    };
    let cells = [sweep.front().unwrap(), sweep.maps().unwrap()].concat();
    let by_cost = |a: &&Cell, b: &&Cell| a.cost().total_cmp(&b.cost());
    let (means, single): (Vec<&Cell>, Vec<&Cell>) =
        cells.iter().filter(|cell| cell.change.is_none()).partition(|cell| cell.config.average().is_some());
    let mut some: Vec<&Cell> = single.into_iter().filter(|cell| cell.r_ohm == 16_200.0).collect();
    some.push(means.into_iter().min_by(by_cost).unwrap());
    // Switches are varied on the paper's board alone.
    for vary in Vary::ALL.into_iter().filter(|vary| *vary != Vary::SwitchFraction) {
        let own = cells.iter().filter(|cell| cell.change.is_some_and(|change| change.columns().0 == vary));
        some.push(own.min_by(by_cost).unwrap());
    }
    let mut measured = 0;
    for cell in some {
        for row in cell.rows(&cell.measure(&|| false).unwrap().unwrap()) {
            measured += 1;
            assert!(
                rows.contains(&row),
                "{row:?} is not in docs/speed-and-accuracy/points.csv: measure it anew, as tests/accuracy/front.rs says"
            );
        }
    }
    assert!(measured >= 7 + Vary::ALL.len(), "{measured}");
}
