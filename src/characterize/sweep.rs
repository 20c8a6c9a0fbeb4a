//! Which cells a sweep has: the front of every method and circuit, and maps of where they fail.

use super::cell::Cell;
use super::change::{Change, Effect};
use super::limits::{
    AVERAGES, CAPACITORS, EFFECT_OHM, FRONT_OHM, JITTERS_S, LEAKAGES_OHM, LEAST_INSTRUMENTS, LONGEST_MEAN,
    MAP_OHM, MOST_DISCHARGES, OFFSET_ERRORS_S, PAPER_OHM, PAPER_READINGS, PAPER_T_L, SETTLING_OHM, SPEEDS,
};
use crate::circuit::{Kind, Node};
use crate::config::{ChannelTable, Config, Measure, Mock, backend};
use crate::pins::sim::{Scene, SceneError};
use crate::reading::Method;
use crate::units::{Nanos, Ohm, Seconds, rounded};

/// The scene of the paper, which is read as the paper says.
const PAPER: &str = "fpga-paper";

/// What maps are made of unless methods are named: that of the paper, what it is compared with, and what users have.
const MAPPED: [(Kind, Method); 4] = [
    (Kind::TwoCapacitor, Method::Tracked),
    (Kind::OneCapacitor, Method::Tracked),
    (Kind::TwoCapacitor, Method::Cerm),
    (Kind::OneCapacitor, Method::Tpcm),
];

/// What is swept; what is absent is chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The name of the scene; of one of a file, that of the file with its ending.
    pub name: String,
    /// The board.
    pub scene: Scene,
    /// How the board is read; absent: as somebody would who knows its parts, in every wiring that it has.
    pub config: Option<Config>,
    /// Only these; empty: all that a circuit allows.
    pub methods: Vec<Method>,
    /// Only these; empty: all that the scene has.
    pub kinds: Vec<Kind>,
    /// Resistances, ohm; empty: a few over the range.
    pub r_ohm: Vec<f64>,
    /// Means over these; [`Nanos::ZERO`]: each reading. Empty: both.
    pub averages: Vec<Nanos>,
    /// How many of each; absent: as many as there is time for.
    pub instruments: Option<u64>,
    /// Of the first of them.
    pub seed: u64,
}

/// How many instruments, and readings of each.
type Extent = (u64, usize);

impl Sweep {
    /// Error against time: methods, wirings, resistances and means.
    ///
    /// # Errors
    /// The scene has not what a wiring needs.
    pub fn front(&self) -> Result<Vec<Cell>, SceneError> {
        let mut cells = if self.is_papers() && self.is_whole() { self.paper()? } else { Vec::new() };
        for (kind, method) in self.ways() {
            let averages = if self.averages.is_empty() { &AVERAGES[..] } else { &self.averages };
            for (average, r_ohm) in
                averages.iter().flat_map(|average| self.resistances(&FRONT_OHM).map(move |r| (average, r)))
            {
                let cell = self.cell(kind, method, *average, r_ohm, None, counts(*average))?;
                if !self.averages.is_empty() || is_worthwhile(&cell) {
                    cells.push(cell);
                }
            }
        }
        Ok(cells)
    }

    /// Where methods fail, what errors are made of, and how they settle after the start.
    ///
    /// # Errors
    /// As [`front`](Sweep::front).
    pub fn maps(&self) -> Result<Vec<Cell>, SceneError> {
        let mut cells = Vec::new();
        let each =
            |of: &[f64], change: fn(f64) -> Change| of.iter().map(|value| change(*value)).collect::<Vec<_>>();
        // With a common clock nothing is late.
        let jitters = if self.scene.clock_period.is_none() { &JITTERS_S[..] } else { &[] };
        let mut maps = each(jitters, |s| Change::Jitter(Seconds(s)));
        maps.extend(each(&CAPACITORS, Change::Capacitor));
        maps.extend(each(&LEAKAGES_OHM, |ohm| Change::Leakage(Ohm(ohm))));
        maps.extend(each(&SPEEDS, Change::Speed));
        let offsets = each(&OFFSET_ERRORS_S, |s| Change::OffsetError(Seconds(s)));
        let effects: Vec<Change> = Effect::of(&self.scene).map(Change::Without).collect();
        for (kind, method) in self.ways() {
            let mut add = |changes: &[Change], usual: &[f64], counts: Extent| {
                for (change, r_ohm) in
                    changes.iter().flat_map(|change| self.resistances(usual).map(move |r| (change, r)))
                {
                    cells.push(self.cell(kind, method, Nanos::ZERO, r_ohm, Some(*change), counts)?);
                }
                Ok::<(), SceneError>(())
            };
            if MAPPED.contains(&(kind, method)) || !self.methods.is_empty() {
                add(&maps, &MAP_OHM, (8, 25))?;
            }
            if method.needs_offset() && self.scene.stamps.is_some() {
                add(&offsets, &MAP_OHM, (8, 25))?;
            }
            add(&effects, &EFFECT_OHM, (20, 30))?;
            add(&[Change::SinceStart], &SETTLING_OHM, (20, usize::MAX))?;
        }
        Ok(cells)
    }

    /// The resistors, methods and counts of the paper, with section IV's circuits.
    fn paper(&self) -> Result<Vec<Cell>, SceneError> {
        let cell = |(kind, method), r_ohm, change| {
            self.cell(kind, method, Nanos::ZERO, r_ohm, change, (10, PAPER_READINGS))
        };
        let ways = [
            (Kind::OneCapacitor, Method::Tpcm),
            (Kind::TwoCapacitor, Method::Tcdic),
            (Kind::TwoCapacitor, Method::Cerm),
        ];
        let each = ways.into_iter().flat_map(|way| PAPER_OHM.map(|r_ohm| cell(way, r_ohm, None)));
        let inferred = self.inferred()?.into_iter();
        let inferred = inferred.map(|(r_ohm, fraction)| {
            cell((Kind::TwoCapacitor, Method::Cerm), r_ohm, Some(Change::SwitchFraction(fraction)))
        });
        each.chain(inferred).collect()
    }

    /// Fig. 5: inferred at all resistances, with the switch where A crosses, and after T_L where that is before. Ohm, and the part
    /// of T_xA.
    fn inferred(&self) -> Result<Vec<(f64, f64)>, SceneError> {
        let circuit = backend::circuit_of(&self.scene.clone().with_kind(Kind::TwoCapacitor)?);
        let limit = |r_ohm: f64| {
            let t_xa_s = circuit.g(Node::A)?.0 * (r_ohm + circuit.r_o.0);
            // T_L has three digits: at 681 ohm it is where A crosses.
            Some(rounded(PAPER_T_L.as_seconds() / t_xa_s, 3)).filter(|fraction| *fraction < 1.0)
        };
        let whole = PAPER_OHM.map(|r_ohm| (r_ohm, 1.0)).into_iter();
        Ok(whole.chain(PAPER_OHM.into_iter().filter_map(|r_ohm| Some((r_ohm, limit(r_ohm)?)))).collect())
    }

    /// Whether it is of the board of the paper, read as the paper says, whose figures take their time.
    pub fn is_papers(&self) -> bool {
        self.name == PAPER && self.config.is_none()
    }

    /// Whether nothing is left out.
    pub fn is_whole(&self) -> bool {
        self.methods.is_empty() && self.kinds.is_empty() && self.r_ohm.is_empty() && self.averages.is_empty()
    }

    fn resistances<'a>(&'a self, usual: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let given = if self.r_ohm.is_empty() { usual } else { &self.r_ohm };
        given.iter().copied()
    }

    /// Each wiring with its methods.
    fn ways(&self) -> Vec<(Kind, Method)> {
        let has = |kind: &Kind| match &self.config {
            Some(config) => config.circuit.kind() == *kind,
            None => self.scene.clone().with_kind(*kind).is_ok(),
        };
        let is_wanted = |kind: &Kind| self.kinds.is_empty() || self.kinds.contains(kind);
        let kinds = Kind::ALL.into_iter().filter(has).filter(is_wanted);
        let of = |kind| Method::on(kind).map(move |method| (kind, method));
        let is_asked =
            |(_, method): &(Kind, Method)| self.methods.is_empty() || self.methods.contains(method);
        kinds.flat_map(of).filter(is_asked).collect()
    }

    fn cell(
        &self,
        kind: Kind,
        method: Method,
        average: Nanos,
        r_ohm: f64,
        change: Option<Change>,
        (instruments, readings): Extent,
    ) -> Result<Cell, SceneError> {
        let scene = self.scene.clone().with_kind(kind)?;
        let mut config = self.config.clone().unwrap_or_else(|| config_of(&self.name, &scene));
        // How often is what is swept.
        (config.measure.rate_hz, config.measure.idle) = (None, false);
        config.measure.method = Some(method);
        config.measure.average = Some(average).filter(|average| *average > Nanos::ZERO);
        let (name, seed) = (self.name.clone(), self.seed);
        let one = Cell { name, scene, config, r_ohm, change, seed, instruments: 1, readings };
        let most = (MOST_DISCHARGES / one.cost()) as u64;
        let instruments = self.instruments.unwrap_or(instruments.min(most.max(LEAST_INSTRUMENTS)));
        Ok(Cell { instruments, ..one })
    }
}

/// Whether a mean is one of several readings, and there is time for it.
fn is_worthwhile(cell: &Cell) -> bool {
    let Some(average) = cell.config.average() else { return true };
    let [fastest, usual] = cell.config.cycle(Seconds(0.0)).map(|cycle| average.as_seconds() / cycle.0);
    let several = if cell.config.is_tracked() { fastest } else { usual };
    several >= 2.0 && fastest <= LONGEST_MEAN
}

/// The longer a mean, the fewer there is time for.
fn counts(average: Nanos) -> Extent {
    match average.as_seconds() {
        s if s <= 0.0 => (30, 40),
        s if s <= 0.02 => (20, 30),
        s if s <= 0.2 => (20, 8),
        s if s <= 2.0 => (40, 2),
        _ => (20, 1),
    }
}

/// What somebody would write who knows the parts of a board, its one channel being commissioned.
fn config_of(name: &str, scene: &Scene) -> Config {
    let resolution = scene.clock_period.map(Nanos::from);
    // Section IV and V: 2^13 cycles of charge, T_L = 616 cycles, the switch where node A crosses.
    let measure = if name == PAPER {
        Measure {
            charge_time: Some(Nanos(163_840)),
            settle_time: Some(Nanos::ZERO),
            t_l: Some(PAPER_T_L),
            switch_fraction: Some(1.0),
            ..Measure::default()
        }
    } else {
        Measure::default()
    };
    Config {
        measure: Measure { resolution, ..measure },
        mock: Some(Mock { scene: name.to_owned(), seed: None }),
        ..Config::of(backend::circuit_of(scene), vec![ChannelTable::commissioned("x", 0.0)])
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Row;
    use super::*;
    use crate::chance::mean_of;
    use crate::config_file::config;

    fn sweep(name: &str) -> Sweep {
        let scene = Scene::builtin(name).unwrap();
        Sweep {
            name: name.to_owned(),
            seed: scene.seed,
            scene,
            config: None,
            methods: Vec::new(),
            kinds: Vec::new(),
            r_ohm: Vec::new(),
            averages: Vec::new(),
            instruments: None,
        }
    }

    #[test]
    fn every_cell_of_every_board_can_be_run_and_is_another_question() {
        for name in Scene::builtin_names() {
            let sweep = sweep(name);
            let cells = [sweep.front().unwrap(), sweep.maps().unwrap()].concat();
            let asked: Vec<_> = cells.iter().flat_map(Cell::asked).collect();
            for (index, row) in asked.iter().enumerate() {
                let other = asked[..index].iter().find(|other| other.is_same_cell(row));
                assert!(other.is_none(), "{row:?}");
            }
            for cell in &cells {
                cell.check().unwrap();
                // So that an unlimited number of readings comes to its end.
                assert!(cell.readings < 1000 || cell.change == Some(Change::SinceStart), "{cell}");
            }
        }
    }

    #[test]
    fn a_rate_in_a_configuration_is_not_in_the_way_of_means() {
        for line in ["rate-hz = 20.0", "rate-hz = 20.0\nidle = true"] {
            let file = config(|c| c.channel("x").set("mock.scene", "pi4").lines("measure", line));
            let sweep = Sweep { config: Some(file.parse()), ..sweep("pi4") };
            for cell in sweep.front().unwrap() {
                cell.check().unwrap();
                assert_eq!((cell.config.period(), cell.config.measure.rate_hz), (None, None), "{cell}");
            }
        }
    }

    #[test]
    fn what_is_asked_for_is_all_that_is_swept() {
        let only = Sweep {
            methods: vec![Method::Tracked, Method::Qerm],
            kinds: vec![Kind::OneCapacitor, Kind::SeriesCalibration],
            r_ohm: vec![470.0],
            averages: vec![Nanos::ZERO],
            instruments: Some(7),
            ..sweep("fpga-paper")
        };
        let cells = only.front().unwrap();
        let names: Vec<String> = cells.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["tracked, one-capacitor, 470 ohm", "qerm, series-calibration, 470 ohm"]);
        assert!(cells.iter().all(|cell| cell.instruments == 7));
        let file = Sweep { name: "fpga-paper.toml".to_owned(), ..sweep("fpga-paper") };
        assert!(!file.is_papers(), "whatever is in it");
        let whole = sweep("fpga-paper").front().unwrap();
        let papers = whole.iter().filter(|cell| cell.readings == PAPER_READINGS);
        // The resistances above 681 ohm a fifth time.
        assert_eq!(papers.count(), 4 * PAPER_OHM.len() + 17);
    }

    /// Of how inferred times scatter, as parts of what T_c2A scatters by: docs/accuracy-paper.md has 1.93 and 1.17 by the full
    /// equations (20) and (22) with 330 nF / 22 nF, whatever R_x, as long as the switch comes where A crosses.
    #[test]
    fn inferred_times_scatter_as_the_full_equations_say() {
        let cells = sweep("fpga-paper").front().unwrap();
        let scatter = |r_ohm: f64, is_whole: bool| {
            let is_it = |cell: &&Cell| match cell.change {
                Some(Change::SwitchFraction(fraction)) => {
                    cell.r_ohm == r_ohm && (fraction == 1.0) == is_whole
                }
                _ => false,
            };
            let cell = cells.iter().find(is_it).unwrap();
            let row = |index: u64| {
                let cell = Cell { instruments: 1, seed: crate::seed::seed(index), ..cell.clone() };
                cell.rows(&cell.measure(&|| false).unwrap().unwrap()).remove(0)
            };
            let rows: Vec<_> = (0..20).map(row).collect();
            let of = |part: fn(&Row) -> Option<f64>| {
                let ratios = rows.iter().map(|row| part(row).unwrap() / row.t_c2a_rsd.unwrap());
                mean_of(&ratios.collect::<Vec<_>>())
            };
            [of(|row| row.t_ixa_rsd), of(|row| row.t_ixb_rsd)]
        };
        for r_ohm in [100.0, 681.0, 16_200.0] {
            let [a, b] = scatter(r_ohm, true);
            // The page has three digits, and a cycle of the clock adds a hundredth to T_c2A.
            assert!(a.is(1.93, 0.02) && b.is(1.17, 0.02), "{r_ohm} ohm: {a}, {b}");
        }
        let early = scatter(16_200.0, false);
        assert!(early.into_iter().all(|part| part.is_in(10.0..=f64::INFINITY)), "{early:?}");
    }
}
