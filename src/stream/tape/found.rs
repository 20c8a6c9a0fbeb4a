//! What looks find, as a tape has it: for programs that look, which a client does not.

use super::TapeLooks;
use crate::estimate::look::Found;

impl TapeLooks {
    /// What a tape may have of it: where the circuit was another one meanwhile, there is no telling what a look has shown.
    pub fn of(found: &Found) -> TapeLooks {
        let apart = |of: Option<[[f64; 2]; 2]>| of.map(turned).map_or([None; 2], |of| of.map(Some));
        let [leak_siemens, leak_u_siemens] = apart(found.leak_siemens);
        let [leak_b_siemens, leak_b_u_siemens] = apart(found.leak_more_at_b);
        let [late_ns, late_u_ns] = apart(found.late_ns);
        let looks = TapeLooks {
            leak_siemens,
            leak_u_siemens,
            leak_b_siemens,
            leak_b_u_siemens,
            late_ns,
            late_u_ns,
            absorbed: found.absorbed,
        };
        if looks.check().is_ok() { looks } else { TapeLooks::default() }
    }

    /// The same for who reads it.
    pub fn found(&self) -> Found {
        let both = |value: Option<[f64; 2]>, u: Option<[f64; 2]>| Some(turned([value?, u?]));
        Found {
            leak_siemens: both(self.leak_siemens, self.leak_u_siemens),
            leak_more_at_b: both(self.leak_b_siemens, self.leak_b_u_siemens),
            late_ns: both(self.late_ns, self.late_u_ns),
            absorbed: self.absorbed,
        }
    }
}

/// Values and their uncertainties side by side, from values with theirs, or the other way round.
fn turned([[a, b], [c, d]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [[a, c], [b, d]]
}
