//! One circuit with its settings: what is built, and the configuration that measures with it.

use super::limits::{PART_LOW, SENSE_OHM, SUPPLY_HIGH};
use super::{Platform, Price, Stock};
use crate::circuit::{Circuit, Kind, Network};
use crate::config::{ChannelTable, Config, Measure};
use crate::units::{Farad, Nanos, Ohm};

/// How often readings are published.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// As they come.
    Each,
    /// The mean over so long.
    Mean(Nanos),
    /// So many a second, each the mean since the one before.
    Hertz(f64),
}

/// One circuit with its settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// The capacitors and how they are wired; every node has a charger of its own.
    pub network: Network,
    /// The calibration resistors.
    pub r_c: [Ohm; 2],
    /// In series with each charger.
    pub r_p: Ohm,
    /// In series with the sensor.
    pub r_lim: Ohm,
    /// The longest discharge through the sensor; `None`: as derived.
    pub deadline: Option<Nanos>,
    /// How often readings are published.
    pub pace: Pace,
}

/// The least resistance between the supply and ground for a pin of so many ampere.
pub fn least_ohm(platform: &Platform, pin_a: f64) -> f64 {
    SUPPLY_HIGH * platform.v_dd.0 / (PART_LOW * pin_a)
}

impl Design {
    /// Its capacitors, that of node A first.
    pub fn capacitors(&self) -> Vec<Farad> {
        match self.network {
            Network::TwoCapacitor { c_a, c_b } => vec![c_a, c_b],
            Network::OneCapacitor { c } | Network::SeriesCalibration { c } => vec![c],
        }
    }

    /// How many nodes are charged and sensed.
    pub fn nodes(&self) -> usize {
        self.network.kind().nodes().len()
    }

    /// The circuit as planned with.
    pub fn circuit(&self, platform: &Platform) -> Circuit {
        Circuit {
            network: self.network,
            r_c1: self.r_c[0],
            r_c2: self.r_c[1],
            v_dd: platform.v_dd,
            v_th: platform.v_th,
            r_charge: Ohm(self.r_p.0 + platform.r_o.0),
            r_o: platform.r_o,
        }
    }

    /// The configuration, with one sensor whose zero and scale have been measured.
    pub fn config(&self, platform: &Platform) -> Config {
        let (rate_hz, average) = match self.pace {
            Pace::Each => (None, None),
            Pace::Mean(time) => (None, Some(time)),
            Pace::Hertz(hertz) => (Some(hertz), None),
        };
        let channel = ChannelTable::commissioned("sensor", self.r_lim.0);
        let measure = Measure { rate_hz, average, deadline: self.deadline, ..Measure::default() };
        Config { measure, ..Config::of(self.circuit(platform), vec![channel]) }
    }

    /// Where pins carry most, and how much, with nothing counted for the pin: charger at power-up, R_1, the sensor shorted; A.
    pub fn currents(&self, platform: &Platform) -> [(&'static str, f64); 3] {
        let amperes = |r: Ohm| platform.v_dd.0 / r.0;
        [
            ("charger, at power-up", amperes(self.r_p)),
            ("sink of Rc1", amperes(self.r_c[0])),
            ("sink of the sensor, sensor shorted", amperes(self.r_lim)),
        ]
    }

    /// Resistors that need not be exact: chargers, inputs, sensor.
    pub fn usual(&self) -> Vec<Ohm> {
        let each = [self.r_p, Ohm(SENSE_OHM)].into_iter().cycle().take(2 * self.nodes());
        each.chain([self.r_lim]).collect()
    }

    /// What it costs.
    pub fn price(&self, stock: &Stock) -> Price {
        stock.price(&self.capacitors(), &self.usual())
    }

    /// How it is wired.
    pub fn kind(&self) -> Kind {
        self.network.kind()
    }
}
