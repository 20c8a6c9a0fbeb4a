//! The text around the table of `docs/dynamic.md`.

pub const HEAD: &str = "# A sensor that changes while it is read

A discharge takes its time: about 1 us for each ohm with 2.2 uF / 680 nF. Each crossing tells the mean conductance
1/(R_x+Ro) over its stretch of the discharge. The stated instant of a reading (`time`, `t_mono_ns`) is the weighted mean
of the middles of these stretches: for a steady change the reading is R_x at that instant.

What is left is of the second order. It is predicted from the last six readings and from what the two nodes of each of
them disagree by, and added to the stated uncertainty. A predicted error of more than 1 % (and more than three times what
noise makes) is no number: the reading is `fault`, `unsettled`. So is a discharge whose crossings contradict each other as
a changing sensor makes them; if one late stamp would do, after readings that were at rest, it is `latency-outlier`.

Everything below is **simulated**: board `pi4` without its rare late stamps, R_x = R (1 + 0.2 sin(2 pi f t)), 8
instruments with 150 readings each. Written by `UPDATE_DOCS=1 cargo test --test accuracy dynamic`; do not edit. `predicted` is the
second order of a full discharge (1 sigma), `u` the median of what is stated, noise included, `within 2u` the share of the
numbers that are R_x at their instant within twice their own sigma. Empty: hardly a number is left.

| method | R / ohm | f / Hz | predicted / % | u / % | within 2u / % | unsettled / % |
|---|--:|--:|--:|--:|--:|--:|
";

pub const TAIL: &str = "
## What cannot be seen

- One stretch tells no slope: `tpcm`, `qerm`, and `cerm` and `tracked` when they switch before A crosses. Then a change shows only
  from reading to reading, and one that comes back between two of them does not show: above about a quarter of the rate
  of readings the stated uncertainty is too small. Where `tracked` switches, the sensor's part is so short (1 ms at 1 kohm)
  that 20 Hz do no harm.
- A motion in step with the readings shows the same value and slope each time, and at its turning points nothing tells of it:
  `tcdic` at 16.2 kohm and 10 Hz was off by up to 16 u during the first look for a leak, 5 s after the start, whose cycles last
  0.1 s.
- A change that repeats within one discharge averages out in it; it is told by what is left of it.
- A step in the middle of a single stretch gives a value in between. It is `unsettled` because nothing before it was as
  fast; on a sensor that steps all the time it may pass.
- A late stamp while the sensor moves looks like motion, unless it is very late: the readings of a moving hand are as good
  as the kernel's latency lets them. With one stretch it looks so at rest, too: one reading is `unsettled`, and forgotten when
  the next one is back.
- Two nodes that disagree always by some sigma, by leakage or by wide-band noise at the threshold, look like a sensor that
  every discharge catches in the same motion: at rest a part of the readings is `unsettled` then (rows 5 and 18 of
  [stability.md](stability.md)).
";
