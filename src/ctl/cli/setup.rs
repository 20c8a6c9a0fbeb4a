//! The command line of `cermctl setup`.

use super::{ConfigFile, Connection};
use clap::Args;

/// `cermctl setup`.
#[derive(Debug, Args)]
pub struct Setup {
    /// Ask nothing: what no option says is as on the drawings
    #[arg(long)]
    pub yes: bool,
    /// Take it back: the service stopped, the configuration as it was before
    #[arg(long)]
    pub undo: bool,
    /// The GPIO chip, by label, name or path [default: that of a Raspberry Pi's header]
    #[arg(long, value_name = "CHIP")]
    pub chip: Option<String>,
    /// A simulated board in the place of a chip: ideal, fpga-paper, pi-zero, pi4 or pi5
    #[arg(long, value_name = "NAME", conflicts_with = "chip")]
    pub scene: Option<String>,
    /// Capacitors: one, or two
    #[arg(long, value_name = "one|two")]
    pub wiring: Option<String>,
    /// C_A as printed, such as "2.2 uF"
    #[arg(long, value_name = "CAPACITANCE")]
    pub c_a: Option<String>,
    /// C_B as printed
    #[arg(long, value_name = "CAPACITANCE")]
    pub c_b: Option<String>,
    /// The only capacitor as printed
    #[arg(long, value_name = "CAPACITANCE", conflicts_with_all = ["c_a", "c_b"])]
    pub c: Option<String>,
    /// Rc1 as measured, such as "468.2 ohm"
    #[arg(long, value_name = "RESISTANCE")]
    pub r_c1: Option<String>,
    /// Rc2 as measured
    #[arg(long, value_name = "RESISTANCE")]
    pub r_c2: Option<String>,
    /// Rp of a charger and its pin, such as "260 ohm" [default: by the chip, as hw/wiring.md has it]
    #[arg(long, value_name = "RESISTANCE")]
    pub r_charge: Option<String>,
    /// What is measured: fsr402 for force by its data sheet, ohm for resistance alone
    #[arg(long, value_name = "fsr402|ohm")]
    pub sensor: Option<String>,
    /// The name of the sensor in the stream
    #[arg(long, value_name = "ID", default_value = "thumb")]
    pub id: String,
    /// Any other value of the configuration, such as gpio.sense-a=GPIO17 or channel.law.kind=pt1000; several times for several
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Write and test the configuration, and leave the service alone
    #[arg(long)]
    pub no_service: bool,
    #[command(flatten)]
    pub file: ConfigFile,
    #[command(flatten)]
    pub connection: Connection,
}
