//! Constants of judgement: where an estimate stops believing.

use crate::units::Nanos;

/// What is so many sigma from what was expected is not noise, of which it is one value in two million. Crossings of one
/// discharge that disagree by more cannot both be right; a resistance so far below 0 is none; a crossing so far from the
/// running mean is a spike.
pub const BEYOND_NOISE: f64 = 5.0;
/// A resistance below so many sigma cannot be told from a short circuit; bounds are stated with the same factor (95 %, GUM).
pub const COVERAGE: f64 = 2.0;
/// Of readings near a short circuit those are told from it by chance that noise has put farthest up: where fewer than one in five are,
/// more than one in ten of them is off by more than two sigma (normal values).
pub const MOSTLY_UNRESOLVED: f64 = 0.8;
/// Over so many readings.
pub const UNRESOLVED_MEMORY: f64 = 32.0;
/// Residuals that disagree by more sigma enlarge the uncertainty as much (Birge's ratio): chance does so once in 70 readings.
pub const DOUBT: f64 = 2.45;
/// A conductance of fewer sigma is not told from none: chance makes one reading in 10^9 of an open sensor a number.
pub const RESOLVED: f64 = 6.0;

// Paths beside the resistors.
/// No pin that sinks has a higher output resistance, ohm: 3.3 V would drive 16 mA.
pub const HIGHEST_R_O_OHM: f64 = 200.0;
/// No kernel stamps crossings later on average, ns.
pub const LATEST_STAMP_NS: f64 = 100_000.0;
/// The latency offset as long as nobody has found it, ns, 1 sigma: boards stamp 4 to 20 us late on average (hw/scenes).
pub const UNKNOWN_OFFSET_NS: f64 = 20_000.0;
/// The noise of crossings as long as it is not known, ns, 1 sigma: kernels of boards were found to stamp within 7 us
/// (hw/scenes).
pub const UNKNOWN_JITTER_NS: f64 = 10_000.0;
/// The part of it that is in proportion to the time, as a share of that: 3 mV at a threshold of 1 V.
pub const UNKNOWN_NOISE: f64 = 3e-3;
/// The calibration resistors may differ so much from what the configuration says, relative.
pub const RESISTOR_TOLERANCE: f64 = 0.08;

// Leaks, by discharges that were held back.
/// After which part of a discharge a current into or out of the node does what it does on average, whatever the threshold (from
/// 0.52 for one of 0.6 V_DD to 0.58 for one of 0.15 V_DD).
pub const LEAK_AVERAGE: f64 = 0.55;
/// After which parts of it discharges are held: what flows through a resistor to ground looks alike at both, and nothing else does.
/// One that were held later would end meanwhile where a leak is just no defect.
pub const LEAK_HELD_AT: [f64; 2] = [0.1, 0.6];
/// A leak of which nobody knows before there has been a look, siemens: as much as is no defect.
pub const LIKELY_LEAK_SIEMENS: f64 = GROSS_LEAK_SIEMENS;
/// How long a discharge is held at the most.
pub const LEAK_HOLD: Nanos = Nanos(40_000_000);
/// How far one that is just no defect takes it meanwhile, in parts of its way: not to its end, nor a pull-up to the supply, which would
/// hide how much it is.
pub const LEAK_TAKES: f64 = 0.39;
/// From one discharge that is held at a level to the next at the same.
pub const LEAK_EVERY: Nanos = Nanos(10_000_000_000);
/// Held discharges that are remembered of each level: of two minutes.
pub const LEAK_REMEMBERED: usize = 12;
/// The first held discharges follow each other; fewer, of both levels together, tell little.
pub const LEAK_FIRST: usize = 8;
/// One comes before the first reading, and if it shows a defect, which no uncertainty allows for, so many in all: a spike is not in
/// each of them.
pub const LEAK_GROSS_FIRST: usize = 2;
/// What looks show is there beyond so many sigma.
pub const LOOK_SHOWS: f64 = 4.0;
/// Beyond so many sigma from the others a single one may be news: another look does no harm.
pub const LOOK_SURPRISE: f64 = 2.5;
/// 1 sigma of what the median deviation of n normal values tells of their own sigma, as a part of it, times the root of n.
pub const OF_DEVIATION: f64 = 1.17;
/// A leak through less than this is a defect, not an imperfection: capacitors insulate more than 1 Gohm, pulls of
/// processors are 30 to 100 kohm.
pub const GROSS_LEAK_SIEMENS: f64 = 1.0 / 200e3;
/// V_DD in parts of the threshold of usual inputs, 1.1 V of 3.3 V. What flows beside the resistors is known at two places of a discharge:
/// between them it depends little on this, until B crosses more.
pub const FALLS: f64 = 3.0;
/// A discharge of the sensor of which a greater part went beside it tells a bound alone.
pub const MOST_BESIDE: f64 = 0.5;
/// What is left of the error that a leak of G to ground has made where it is undone, 1 sigma, with one node and with two: as a part of it,
/// of G R_1 R_2, since the calibration is off, and of G R_x R_2.
pub const LEAK_LEFT: [[f64; 3]; 2] = [[0.01, 0.0, 0.0], [0.01, 0.01, 0.003]];
/// The same of what B loses more than A and is not undone.
pub const LEAK_AT_B: [f64; 3] = [1.0, 1.0, 0.2];
/// How much of what is undone at B may be left, in parts of itself times R_2: B falls as by a conductance and a current only as long as
/// both are small.
pub const LEAK_LARGE_AT_B: f64 = 3.0;
/// By which part of what late levels show more than early ones that may be more or less as B crosses.
pub const BEYOND_LATE: f64 = 0.15;
/// What B does to readings that only A ends, in parts of that.
pub const BY_CALIBRATION: f64 = 0.15;
/// What a leak that is none to ground leaves beside that, 1 sigma, where both levels differ by K siemens: as a part of the error that K
/// to ground would make; of K R_1 R_2 and of K R_x R_2, since the calibration is off; and of K R_x^2 t_2/t_1 for a discharge that goes on for
/// t_2 after t_1 through the sensor, up to A and up to B, since K does more to its end than to its beginning. Found with
/// tests/accuracy, hostile.
pub const LEAK_BENT: [[f64; 5]; 2] = [[0.4, 0.4, 0.0, 1.0, 1.0], [1.5, 1.6, 0.6, 3.0, 4.0]];

// Dielectric absorption, by discharges after a rest at V_DD; found with tests/stability, dielectrics.
/// How long a rest is: what is filled more slowly than that does little to discharges that are shorter.
pub const ABSORPTION_REST: Nanos = Nanos(20_000_000);
/// From one such discharge to the next.
pub const ABSORPTION_EVERY: Nanos = Nanos(5_000_000_000);
/// How many of them are remembered: those of five minutes.
pub const ABSORPTION_REMEMBERED: usize = 64;
/// The first of them follow each other; fewer tell little.
pub const ABSORPTION_FIRST: usize = 16;
/// What they show is likely beyond so many sigma: chance makes one of none once in 400 times.
pub const ABSORPTION_LIKELY: f64 = 3.0;
/// By which part of R_1 a reading is off, 1 sigma, for each share that a discharge is longer after a rest.
pub const BY_ABSORPTION: f64 = 2.5;
/// From this part of R_1 on, what R_x is more is off by the same share.
pub const ABSORPTION_GROWS: f64 = 1.3;

// What the law leaves out, by split discharges that switch elsewhere; found with tests/accuracy, drawn.
/// When they do, in parts of node A's time through R_1.
pub const ELSEWHERE: f64 = 0.98;
/// So many sigma of a crossing before A at the least.
pub const ELSEWHERE_MARGIN: f64 = 1.0;
/// An earlier one shows little beside those of calibration.
pub const ELSEWHERE_AT_LEAST: f64 = 0.94;
/// One split discharge in so many does.
pub const ELSEWHERE_EVERY: u32 = 4;
/// The first late ones follow each other; fewer tell little.
pub const ELSEWHERE_FIRST: usize = 6;
/// Until there are so many, half of them are.
pub const ELSEWHERE_YOUNG: usize = 40;
/// How many are remembered.
pub const ELSEWHERE_REMEMBERED: usize = 256;
/// What they show is there beyond so many sigma.
pub const ELSEWHERE_SHOWS: f64 = 3.0;
/// By which part of R_1 a reading is off, 1 sigma, for each of R_2's time that they are beside the state.
pub const BY_ELSEWHERE: f64 = 1.5;
/// The same between R_1 and R_2, where it is greatest.
pub const BY_ELSEWHERE_ABOVE: f64 = 7.0;

// Stamps that are later after long waits, by calibration discharges in which the program wakes before they end; found with
// tests/accuracy, hostile.
/// When it does, before they end: so many sigma of a crossing, and [`LATEST_STAMP_NS`].
pub const AWAKE_MARGIN: f64 = 6.0;
/// Of plain discharges that a calibration is followed by, so many are such ones, and then one in so many.
pub const AWAKE_YOUNG: usize = 40;
/// See there.
pub const AWAKE_EVERY: u32 = 2;
/// The first of them follow each other; fewer tell little.
pub const AWAKE_FIRST: usize = 10;
/// So many pairs of one that is and one that is not tell more than the state does.
pub const AWAKE_PAIRS: usize = 32;
/// The same beside calibration discharges that are taken anew for each reading.
pub const AWAKE_AGAIN: Nanos = Nanos(500_000_000);
/// How many are remembered through either resistor.
pub const AWAKE_REMEMBERED: usize = 256;
/// What they show is there beyond so many sigma.
pub const AWAKE_SHOWS: f64 = 3.0;
/// And is in the uncertainty of what a tracked calibration reads, beyond so many.
pub const AWAKE_COUNTS: f64 = 2.5;

// Noise of crossings.
/// The largest share of a crossing's variance that both crossings have in common, whatever the resistor.
pub const SHARED_VARIANCE: f64 = 0.5;
/// A covariance is in proportion to the times when it is so many sigma greater through R_2 than through R_1.
pub const PROPORTIONAL_SHOWS: f64 = 3.0;
/// What crossings owe to the discharge before, nine time constants of charge later, in parts of their time: it differs from one order
/// of discharges to another and shows in no scatter. Less noise than that is not believed.
pub const REMEMBERED: f64 = 3e-5;
/// Discharges taken before anything is said about noise.
pub const NOISE_WARM_UP: usize = 16;
/// Discharges that the share of those far off is the mean of, about.
pub const FAR_OF: f64 = 64.0;
/// Of a usual board one discharge in fifty is far off; so many are not by chance, and those that are near may be late as well.
pub const OFTEN_LATE: f64 = 0.15;
/// So few are accidents, of which no two come together.
pub const SELDOM_LATE: f64 = 0.03;
/// What late stamps do by chance with this probability they do not do.
pub const BY_CHANCE: f64 = 1e-6;
/// How likely one is as late as another, within noise.
pub const ALIKE_BY_CHANCE: f64 = 0.25;
/// Readings among which others like one are looked for.
pub const REPEATS_OF: usize = 12;
/// What is less far is no late stamp, however small the noise, ns: on a board without any, all that is new is many sigma away.
pub const LATE_NS: f64 = 20_000.0;
/// So many outliers in a row are no late stamps, however frequent these are.
pub const NEVER_SO_LATE: u32 = 12;
/// Of the first stamps, so many that are so many sigma from the others are too many: steps tell nothing then. (Sigma by the
/// shortest third of 16 normal values is too small by ten once in a thousand times, and 4 of them are beyond 2 sigma once in a
/// hundred.)
pub const TOO_MANY_LATE: (usize, f64) = (4, 20.0);
/// How wide the shortest interval with 6 of 16 normal values is on average, in sigma.
pub const SHORTEST_THIRD: f64 = 0.507;
/// For how many differences of successive discharges such an interval stands: the 6 values in it have 5.
pub const WEIGHT_OF_A_THIRD: f64 = 5.0;
/// So many outliers in a row are a step: the mean, or the filter, starts anew.
pub const OUTLIERS_OF_A_STEP: u32 = 3;
/// Differences of successive discharges that are remembered, about.
pub const NOISE_MEMORY: f64 = 2048.0;
/// The first of many dips is early by so much for each e-fold of its time, in parts of what it scatters by, and so skewed: to 5 %
/// and 15 % with 30 to 10^5 independent values of the noise while the node falls by one sigma of it.
pub const EARLY_OF_SCATTER: f64 = 0.82;
pub const SKEW_OF_FIRST: f64 = 0.8;
/// Skewness begins to count at so many sigma, and counts in full at so many.
pub const SKEW_SHOWS: [f64; 2] = [2.0, 3.0];

// Where most values are.
/// A step towards a value, in parts of how far values usually are from their median.
pub const USUAL_STEP: f64 = 1.0 / 16.0;

// How wide a gate is.
/// A value that is refused widens the gate by this factor.
pub const GATE_WIDER: f64 = 1.5;
/// A value that is let in narrows it by this part.
pub const GATE_NARROWER: f64 = 1.0 / 80.0;
/// A gate becomes no wider than so many times its least width; what is beyond that is a spike, however frequent, and does
/// not widen it.
pub const GATE_WIDEST: f64 = 4.0;

// Motion of the sensor; found with tests/accuracy, dynamic.
/// Readings that are remembered.
pub const MOTION_POINTS: usize = 6;
/// So many times less uncertain is known much better: what is known so much worse is like anything, and tells no late stamp.
pub const MUCH_BETTER: f64 = 2.0;
/// A sensor whose readings have a larger predicted error, relative, moves fast: crossings that contradict each other are its
/// own then.
pub const FAST: f64 = 0.01;
/// A predicted error below so many sigma may be noise.
pub const STATED: f64 = 3.0;
/// A reading that is above the way of those before it by more sigma may have a late stamp.
pub const LATE_ON_ITS_WAY: f64 = 4.0;
/// What is so many times faster than everything before it was not to be expected.
pub const SUDDEN: f64 = 3.0;
/// Where the square of the slopes inside of discharges is no more than so many times that of the speed from reading to reading,
/// readings follow the sensor: what oscillates so fast that they do not turns round in less than two and a half of them.
pub const FOLLOWED: f64 = 2.0;
/// How far above its lower bound an open sensor is taken to be, in ln, give or take as much.
pub const OPEN_LN: f64 = 0.7;
/// Stretches that differ by a smaller share of the longer one tell no slope.
pub const APART: f64 = 0.2;

// Means of readings.
/// Readings that share a calibration: as many blocks of them tell by how much it scatters.
pub const BLOCKS_OF_A_MEAN: usize = 10;
/// Residuals of a fit that are smaller are what rounding leaves of none, relative.
pub const NO_RESIDUAL: f64 = 1e-9;
/// Steps from reading to reading that are believed, at the least.
pub const STEPS_OF_A_MEAN: f64 = 16.0;
/// Readings scatter by more than they say when their steps show it with so many sigma.
pub const STEPS_SHOW: f64 = 4.0;
/// Below this part of the variance that they state, what their steps do not show is alike in all of them.
pub const STEPS_LACK: f64 = 0.3;

// Split calibration.
/// The split comes after this part of node A's time through R_1: late, since the difference grows with it, and before any
/// node crosses.
pub const SPLIT_FRACTION: f64 = 0.9;
/// Rounds of a split calibration of which there is a result.
pub const FEWEST_ROUNDS: usize = 4;
/// Switches that their scatter is the mean of, about.
pub const SCATTER_MEMORY: f64 = 4096.0;
/// What is not known of a variance, in sigma, that is added to it.
pub const SCATTER_DOUBT: f64 = 0.25;
/// Readings that bound the scatter of switches, at the least and at the most.
pub const READINGS_OF_SCATTER: [f64; 2] = [16.0, 256.0];
/// The uncertainty of a switch of which neither its recorder nor any split discharge has told one, ns: that of a posted write.
pub const UNTOLD_SWITCH_NS: f64 = 2000.0;
/// The uncertainty of a switch of which nobody has told one, as on a tape, ns: that of a call of a microsecond.
pub const UNKNOWN_SWITCH_NS: f64 = 400.0;

// The tracked calibration; found with tests/accuracy, tracked.
/// Rounds (R_1, R_2, split) from which the first state is found.
pub const FIRST_ROUNDS: usize = 28;
/// Rounds before them that tell Ro, to an ohm on usual boards: what charges go by from then on.
pub const ROUGH_ROUNDS: usize = 4;
/// From so many of these rounds the filter tries to begin.
pub const BEGINNINGS: usize = 8;
/// One in so many of the first discharges may be rejected.
pub const MOST_REJECTED: usize = 8;
/// An innovation beyond so many sigma is rejected.
pub const INNOVATION_GATE: f64 = 4.0;
/// How slowly d, g and Ro walk, per root second: d in parts of its jitter, for what makes the latency jitter makes its mean
/// wander; g relative, beside how fast it drifts, which is part of the state; Ro in ohm, for the temperature of a board changes
/// in minutes.
pub const SLOWEST_WALK: [f64; 3] = [0.0075, 1.5e-5, 0.01];
/// As long as nothing has been seen of them, walks up to this are as likely as each other, and faster ones less: of Ro what a pin does
/// whose driver heats up.
pub const WALK_AT_FIRST: [f64; 3] = [0.0075, 1.5e-5, 1.0];
/// How well the state is known before anything is measured, 1 sigma: g relative, Ro in ohm, each d in ns.
pub const UNKNOWN_STATE: [f64; 3] = [0.05, 50.0, 50_000.0];
/// How fast either g may change at first, 1/s: 1 % in a minute.
pub const RATE_AT_FIRST: f64 = 2e-4;
/// How fast that itself walks, per root second.
pub const RATE_WALK: f64 = 3e-6;
/// For so long at the most the state goes on as it went, s.
pub const LONGEST_AHEAD_S: f64 = 60.0;
/// Speeds of a walk that are compared, from the slowest to 300 times that; twice as many told no more.
pub const SPEEDS: usize = 6;
/// How far each is from the next, as a factor.
pub const SPEEDS_APART: f64 = 3.162;
/// The last observations, about, that say how likely a speed is.
pub const LIKELIHOOD_OF: f64 = 4096.0;
/// None is less likely than the likeliest by more, ln: what begins to walk shows within seconds then, and what stands still is
/// taken to walk faster than the slowest speed by a sixth at the most.
pub const LEAST_LIKELY: f64 = 8.0;
/// What is more sigma from where a speed expects it tells no more against that speed.
pub const TELLING: f64 = 3.0;
/// Discharges of a kind that its mean innovation is taken over.
pub const MISFIT_OF: f64 = 64.0;
/// Mean innovations contradict the state when their mean square is so many times what chance makes it: of six it is more
/// once in fifty.
pub const MISFIT_SHOWS: f64 = 2.5;
