//! What one discharge tells: over which stretches, and whether they agree.

use crate::estimate::limits::{APART, BEYOND_NOISE, STATED};

/// What a discharge tells of R_x, and when it was so. Times in ns since the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// When R_x was what the estimate says.
    pub at_ns: f64,
    /// What z'' and z'² have to be multiplied by, ns².
    pub(super) bend_ns2: f64,
    pub(super) apart_ns2: f64,
    /// What each stretch says alone.
    pub(super) pair: Option<Pair>,
    /// The crossings disagree by more than noise does.
    pub contradicts: bool,
}

/// R_x by each of two stretches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pair {
    pub(super) r_ohm: [f64; 2],
    /// Of their difference, ohm.
    pub(super) u_ohm: f64,
    /// From the middle of one to the middle of the other, s; may be negative. `None`: too close to tell a slope.
    pub(super) apart_s: Option<f64>,
}

impl Pair {
    /// The same as logarithms, which are `all_ohm` of what they were.
    pub(super) fn map(self, through: impl Fn(f64) -> f64, all_ohm: f64) -> Pair {
        Pair { r_ohm: self.r_ohm.map(|r_ohm| through(r_ohm).ln()), u_ohm: self.u_ohm / all_ohm, ..self }
    }

    pub(super) fn difference(self) -> f64 {
        self.r_ohm[1] - self.r_ohm[0]
    }

    /// Whether they differ by no more than so many sigma.
    fn agrees(self, sigmas: f64) -> bool {
        self.difference().abs() <= sigmas * self.u_ohm
    }

    /// Whether they tell a slope.
    pub(super) fn is_apart(self) -> bool {
        self.apart_s.is_some()
    }

    /// With 1 sigma.
    pub(super) fn slope(self) -> Option<[f64; 2]> {
        self.apart_s.map(|apart_s| [self.difference() / apart_s, (self.u_ohm / apart_s).abs()])
    }
}

impl Evidence {
    /// An estimate that rests on one stretch of the discharge.
    pub fn over(end_ns: f64) -> Evidence {
        Evidence {
            at_ns: end_ns / 2.0,
            bend_ns2: end_ns * end_ns / 24.0,
            apart_ns2: 0.0,
            pair: None,
            contradicts: false,
        }
    }

    /// An estimate that has `weights` (sum 1) on two stretches, which alone would say `r_ohm`; `u_ohm` is 1 sigma of the
    /// difference. Where that is not known, nothing contradicts.
    pub fn over_two(end_ns: [f64; 2], weights: [f64; 2], r_ohm: [f64; 2], u_ohm: Option<f64>) -> Evidence {
        let sum = |of: &dyn Fn(f64) -> f64| weights[0] * of(end_ns[0]) + weights[1] * of(end_ns[1]);
        let at_ns = sum(&|end| end / 2.0);
        let apart_ns2 = sum(&|end| (end / 2.0 - at_ns).powi(2));
        let between_ns = (end_ns[1] - end_ns[0]) / 2.0;
        let is_apart = 2.0 * between_ns.abs() > APART * end_ns[0].max(end_ns[1]);
        // Not `>`: what cannot be compared is no agreement.
        let agrees = u_ohm.is_none_or(|u_ohm| (r_ohm[1] - r_ohm[0]).abs() <= BEYOND_NOISE * u_ohm);
        let apart_s = is_apart.then_some(1e-9 * between_ns);
        Evidence {
            at_ns,
            bend_ns2: (sum(&|end| end * end / 24.0) + apart_ns2 / 2.0).abs(),
            apart_ns2: apart_ns2.abs(),
            // One stretch that two crossings tell of cannot contradict itself by a change.
            pair: u_ohm.filter(|_| between_ns != 0.0).map(|u_ohm| Pair { r_ohm, u_ohm, apart_s }),
            contradicts: !agrees,
        }
    }

    /// The same where a defect of the circuit makes the crossings disagree by so much, 1 sigma, ohm.
    pub fn beside(self, defect_ohm: f64) -> Evidence {
        let Some(pair) = self.pair.filter(|_| defect_ohm > 0.0) else { return self };
        let pair = Pair { u_ohm: pair.u_ohm.hypot(defect_ohm), ..pair };
        Evidence { pair: Some(pair), ..self.contradicting(self.contradicts && !pair.agrees(BEYOND_NOISE)) }
    }

    /// Whether a second crossing says the same where stamps are often late: none is late that agrees by chance.
    pub fn is_confirmed(&self) -> bool {
        !self.contradicts && self.pair.is_some_and(|pair| pair.agrees(STATED))
    }

    /// The same, with another word on whether the crossings disagree.
    pub fn contradicting(self, contradicts: bool) -> Evidence {
        Evidence { contradicts, ..self }
    }
}
