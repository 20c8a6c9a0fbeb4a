//! What the instrument runs with: the configuration, every default filled in and every file read.
//!
//! For: the last step from a checked [`Config`] to the measuring thread. Must not know: how a measurement goes.

use crate::circuit::Network;
use crate::config::{self, Config};
use crate::cycle::{MOST_CALIBRATIONS, MOST_OF_SENSOR};
use crate::force::{Force, Table, TableError};
use crate::pins::{Drives, Node};
use crate::reading::Method;
use crate::record::Through;
use crate::units::Nanos;

/// One sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub id: String,
    /// What a short circuit in its place reads, ohm.
    pub zero_ohm: f64,
    /// Its characteristic, if it is to give forces.
    pub force: Option<Force>,
}

/// Where the latency offset comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OffsetSource {
    /// Split calibration.
    Auto,
    /// Given, ns.
    Given(f64),
}

/// Everything that the measuring thread needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// R_1 and R_2 of the [ratio](crate::method), ohm.
    pub r_ohm: [f64; 2],
    /// The circuit has Rc1 and Rc2 in series.
    pub series: bool,
    /// The chargers there are.
    pub chargers: Drives,
    /// When node A should cross in a discharge through R_1, by nominal values, for diagnosis alone.
    pub nominal: Nanos,
    /// The node whose crossing ends a discharge.
    pub last: Node,
    /// Length of what goes before the charge after a discharge that ended before its time.
    pub drain: Nanos,
    /// Length of a charge.
    pub charge: Nanos,
    /// Pause between charge and discharge.
    pub settle: Nanos,
    /// The longest discharge through a sensor.
    pub deadline: Nanos,
    /// From the start of one cycle to the next; `None`: at once.
    pub period: Option<Nanos>,
    /// The latency offset, where the calibration is not tracked.
    pub offset: OffsetSource,
    /// Period of the clock that stamps crossings.
    pub resolution: Nanos,
    /// The calibration is followed over many readings instead of taken anew for each.
    pub tracked: bool,
    /// T_L of eq. (19); `None`: where the predicted uncertainties cross.
    pub t_l: Option<Nanos>,
    /// The planned switch comes at this fraction of the predicted T_xA.
    pub switch_fraction: f64,
    /// The sensors.
    pub channels: Vec<Channel>,
}

/// Why a configuration that passes its check still cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// A force table is not usable.
    #[error("channel {id:?}: force: {source}")]
    Table {
        /// The channel.
        id: String,
        /// Why.
        source: TableError,
    },
}

impl Settings {
    /// Takes over a configuration that has passed [`Config::check`].
    ///
    /// # Errors
    /// A force table that cannot be read or is not monotone.
    pub fn new(config: &Config) -> Result<Settings, SettingsError> {
        let circuit = &config.circuit;
        let r_ohm = [circuit.r_c1.0, circuit.r_second().0];
        let channels = config.channels.iter().map(|channel| {
            let force = channel.force.as_ref().map(|force| load_force(config, force, r_ohm)).transpose();
            let force = force.map_err(|source| SettingsError::Table { id: channel.id.clone(), source })?;
            Ok(Channel { id: channel.id.clone(), zero_ohm: channel.zero_ohm, force })
        });
        Ok(Settings {
            method: config.method(),
            r_ohm,
            series: matches!(circuit.network, Network::SeriesCalibration { .. }),
            chargers: match circuit.network {
                Network::TwoCapacitor { .. } => Drives::CHARGE,
                _ => Drives::CHARGE_A,
            },
            nominal: Nanos::from_seconds(circuit.crossing(Node::A, circuit.r_c1).unwrap_or_default().0),
            last: config.last_node(),
            drain: config.drain_time(),
            charge: config.charge_time(),
            settle: config.settle_time(),
            deadline: config.deadline(),
            period: config.measure.rate_hz.map(|hertz| Nanos::from_seconds(1.0 / hertz)),
            offset: match config.offset() {
                config::Offset::Auto => OffsetSource::Auto,
                config::Offset::Fixed(d) => OffsetSource::Given(d.as_ns()),
            },
            resolution: config.measure.resolution.unwrap_or(Nanos(1)),
            tracked: config.is_tracked(),
            t_l: config.measure.t_l,
            switch_fraction: config.switch_fraction(),
            channels: channels.collect::<Result<_, _>>()?,
        })
    }

    /// How many nodes the method times.
    pub fn nodes(&self) -> usize {
        match self.last {
            Node::A => 1,
            Node::B => 2,
        }
    }

    /// The longest that one discharge can take, whatever is connected: drained, charged, waited for until the deadline, and
    /// finished through a known resistor until another.
    fn discharge(&self) -> Nanos {
        self.drain + self.charge + self.settle + self.deadline + self.deadline
    }

    /// The longest that the share of one reading in a cycle can take, whatever is connected: every discharge taken as often
    /// as it may be, each of them drained, charged, waited for until its deadline, and finished through R_1 until another. What
    /// the system takes beyond what was asked for, such as a preemption, is not in it.
    pub fn longest_reading(&self) -> Nanos {
        Nanos(self.discharge().0 * i64::from(MOST_CALIBRATIONS + MOST_OF_SENSOR))
    }

    /// The discharge of R_2.
    pub fn second(&self) -> Through {
        if self.series { Through::C12 } else { Through::C2 }
    }

    /// What the discharge of a sensor starts through.
    pub fn sensor(&self, channel: usize) -> Through {
        match self.method {
            Method::Qerm => Through::XWithC12(channel),
            Method::Tpcm | Method::Tcdic | Method::Cerm | Method::Tracked => Through::X(channel),
        }
    }
}

fn load_force(config: &Config, force: &config::Force, r_ohm: [f64; 2]) -> Result<Force, TableError> {
    Ok(match force {
        config::Force::Alpha(alpha) => Force::Alpha(alpha.0),
        config::Force::Calibrated { fc1, fc2 } => Force::Pair { r_ohm, f_n: [fc1.0, fc2.0] },
        config::Force::PowerLaw { at_1_kohm, exponent } => {
            Force::Power { scale: at_1_kohm.0 * 1000f64.powf(*exponent), exponent: *exponent }
        }
        config::Force::Table(file) => Force::Table(Table::load(&config.path(file))?),
    })
}
