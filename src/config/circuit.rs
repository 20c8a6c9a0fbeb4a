//! `[circuit]`: the parts on the board, from the flat table of the file to a [`Circuit`].

use crate::circuit::{Circuit, Kind, NOMINAL_R_CHARGE, NOMINAL_R_O, NOMINAL_V_DD, NOMINAL_V_TH, Network};
use crate::units::{Farad, Ohm, Volt};
use serde::Deserialize;
use serde::de::{Deserializer, Error};

/// The table as it is written.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Written {
    /// Which circuit. Required.
    kind: Kind,
    /// C_A between nodes A and B, 10 pF to 1 mF. Required for `two-capacitor`. Nominal: never enters an estimate.
    c_a: Option<Farad>,
    /// C_B from node B to ground, 10 pF to 1 mF, below C_A V_Th / (V_DD - V_Th). Required for `two-capacitor`. Nominal.
    c_b: Option<Farad>,
    /// The only capacitor, 10 pF to 1 mF. Required for the other kinds. Nominal.
    c: Option<Farad>,
    /// Rc1 as measured, 1 ohm to 100 Mohm. Required.
    r_c1: Ohm,
    /// Rc2 as measured, 1 ohm to 100 Mohm, above Rc1 unless in series with it. Required.
    r_c2: Ohm,
    /// Supply voltage, nominal, 0.5 V to 30 V. Default 3.3 V.
    v_dd: Option<Volt>,
    /// Falling threshold of the inputs, nominal, above 0 and below V_DD. Default 1.3 V.
    v_th: Option<Volt>,
    /// Rp + Ro of a charger, nominal, 1 ohm to 100 Mohm. Default 220 ohm.
    r_charge: Option<Ohm>,
}

/// Reads the table; a capacitor that is missing or does not belong to the kind is refused.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Circuit, D::Error> {
    let table = Written::deserialize(deserializer)?;
    let Written { kind, c_a, c_b, c, .. } = table;
    let is_mixed = c.is_some() && (c_a.is_some() || c_b.is_some());
    let network = Network::new(kind, c_a, c_b, c).filter(|_| !is_mixed);
    let network = network.ok_or_else(|| {
        D::Error::custom(match kind {
            Kind::TwoCapacitor => "kind \"two-capacitor\" has the capacitors c-a and c-b, and no c",
            _ => "this kind has one capacitor, c, and neither c-a nor c-b",
        })
    })?;
    Ok(Circuit {
        network,
        r_c1: table.r_c1,
        r_c2: table.r_c2,
        v_dd: table.v_dd.unwrap_or(NOMINAL_V_DD),
        v_th: table.v_th.unwrap_or(NOMINAL_V_TH),
        r_charge: table.r_charge.unwrap_or(NOMINAL_R_CHARGE),
        r_o: NOMINAL_R_O,
    })
}
