//! Constants of judgement: what is still a usual call, a usual board, a reading worth its discharge.

use crate::units::Nanos;

/// A node that falls in less than this part of its predicted time has nothing but wires at it. Printed
/// capacitors are within 20 %, thresholds between a quarter and a half of the supply.
pub const MISSING: f64 = 0.05;

// Calls that are timed.
/// How long a read of levels takes before one has been seen: 1 us on a Pi 4, and what a sleeping link takes to wake up.
pub const FIRST_READ: Nanos = Nanos(5_000);
/// What one read changes in that.
pub const READ_STEP: Nanos = Nanos(200);
/// Between a read of levels and the call after it: more than reads differ by, and less than it takes a link to fall asleep
/// again.
pub const AWAKE: Nanos = Nanos(2_000);
/// Nobody spins for longer than this before a call.
pub const MOST_LEAD: Nanos = Nanos(50_000);
/// A call or an interrupt that ends so shortly before a tick may still meet it.
pub const TICK_SOON: Nanos = Nanos(5_000);
/// How long a tick lasts: 9 us of most of them where clocks count instructions (tests/vm), 30 us where it has more to do.
pub const TICK_LASTS: Nanos = Nanos(40_000);
/// What lasts longer, or is known no better, is not kept clear of it, and no discharge begins much more than that later.
pub const MOST_OF_A_TICK: Nanos = Nanos(120_000);

/// Calls in the middle of a discharge are no more like that which starts it if they differ by more than this share of it: where in its
/// call a line moves nobody knows to better than 0.4 of it.
pub const UNLIKE: f64 = 0.3;
/// So many calls of a kind tell how long they take from then on, and no more of a processor that has just begun.
pub const OFTEN: usize = 200;

// The order of discharges.
/// The longest sleep of one step while waiting for the next cycle, so that the caller can tell its counters in between.
pub const NAP: Nanos = Nanos(100_000_000);
/// A charge that has been left alone for so much longer than was planned leaks away unlike the others. No call takes so
/// long, only a preemption does.
pub const LONGEST_PAUSE: Nanos = Nanos(2_000_000);
/// A calibration discharge that came to nothing is taken again so many times, and a sensor's whose calls were interrupted.
pub const RETRIES: u32 = 2;
/// Discharges of one sensor in one cycle at the most.
pub const MOST_OF_SENSOR: u32 = RETRIES + 1;
/// Calibration discharges of one cycle at the most: of each kind, each of them taken again.
pub const MOST_CALIBRATIONS: u32 = 3 * (RETRIES + 1);
/// Rounds of split calibration after which the offset is better than none: from then on each round betters it at once.
pub const ROUNDS_AT_FIRST: usize = 16;
/// Rounds after which discharges are planned by it.
pub const ROUNDS: usize = 64;
/// Rounds that the offset is the mean of, when there have been that many.
pub const WINDOW: usize = 8 * ROUNDS;
/// Once the offset is known well enough, one cycle in so many has a split discharge.
pub const FOLLOW_EVERY: u64 = 8;
/// For so long node B may float while nobody waits for it: at 1 Mohm beside it a sixth of its charge is gone then.
pub const B_LEFT_ALONE: Nanos = Nanos(250_000_000);
/// Charges follow the board's own time constant in such steps: less does nothing to a reading.
pub const CHARGE_STEP: f64 = 0.05;
/// By so much at the most: more is no tolerance, but another part than the configuration says.
pub const MOST_LONGER: f64 = 1.0;
/// A charge of B that is older is made anew where B is waited for.
pub const B_FORGOTTEN: Nanos = Nanos(50_000_000);

// The plan of the next discharge.
/// The branch that is not in use must promise so much less variance, or the one in use stays: no chatter.
pub const HYSTERESIS: f64 = 0.8;
/// A discharge that is not in use must promise so much less variance times time, or the one in use stays: no chatter. All that it
/// costs is error: at 0.8 one of 13.0 ms that waits for B would stay at 16.2 kohm, where the best takes 10.4 ms.
pub const CHATTER: f64 = 0.95;
/// A calibration discharge pays when what it takes off the variance, relative, times how long that lasts is so many times what
/// the discharge takes. In the steady state P of the calibration goes with the root of the time between discharges, so that
/// half of what the last one brings is what less frequent ones would cost.
pub const CALIBRATION_PAYS: f64 = 2.0;
/// What a late split discharge shows of a board is worth as much as if it were gone after so long: a board keeps its capacitors,
/// but what is published first has to wait for it.
pub const SHOWN_LASTS: Nanos = Nanos(10_000_000_000);
/// A split discharge pays in each cycle while the offset makes more than this share of a switched reading's variance. Its
/// error is the same in all readings: it is a tenth of the noise of one, and as much as the noise of a mean of a hundred.
pub const OFFSET_SHARE: f64 = 0.01;
/// So many calibration discharges of a tracked state, one in so many readings at the least, until noise is known: to 9 % then.
pub const YOUNG: u32 = 120;
/// See there.
pub const YOUNG_EVERY: u32 = 2;
/// Or one for each reading that is longer than this: at 16.2 kohm all have come in two seconds.
pub const YOUNG_PAUSE: Nanos = Nanos(8_000_000);
/// So long without a calibration discharge is too long: a drift would not be seen.
pub const LONGEST_IDLE: Nanos = Nanos(400_000_000);
/// And so long without one of each kind: what one kind shows of a change another may hide, however little it is worth otherwise.
pub const LONGEST_UNSEEN: Nanos = Nanos(2_000_000_000);
/// So many outliers in a row are no spikes: the calibration may be wrong, and is looked at in each cycle.
pub const OUTLIERS_OF_DOUBT: u32 = 2;
/// So many readings in a row that show a leak are no late stamps: a discharge that is held tells at once.
pub const LEAKS_OF_A_LOOK: u32 = 3;
/// Where a switch is considered, as fractions of the time in which the last node crosses.
pub const SWITCH_FRACTIONS: [f64; 9] = [0.2, 0.35, 0.5, 0.65, 0.75, 0.85, 0.9, 0.95, 0.98];
/// What is left after a switch at the least, ns: longer than the calls that make it take.
pub const SHORTEST_TAIL_NS: f64 = 20_000.0;
/// A switch keeps so far clear of the interrupt that A's crossing makes, ns.
pub const CLEAR_NS: f64 = 30_000.0;
/// A sensor may be so many times farther from its last reading than it was from the one before.
pub const RESTLESS: f64 = 3.0;
/// What remains of that from reading to reading.
pub const RESTLESS_KEEPS: f64 = 0.7;
/// How much one discharge changes what is known of the time that calls take.
pub const OVERHEAD_STEP: f64 = 1.0 / 16.0;
/// A switch that has met an interrupt comes earlier by this part when the discharge is taken again.
pub const RETRY_EARLIER: f64 = 0.1;

// Calls that switch lines.
/// Calls whose median is the first value.
pub const FIRST_CALLS: usize = 5;
/// The least step of the median towards a call, in parts of it.
pub const CALL_STEP: f64 = 0.01;
/// A usual call is longer than the median by no more than this part of it, and as many ns more; where many calls are
/// longer, by as much as the gate becomes wider.
pub const LONGER_CALL: (f64, f64) = (0.5, 1000.0);
