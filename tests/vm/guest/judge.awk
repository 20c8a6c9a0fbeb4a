# judge.awk -v calibration=own|shared|defect [-v by_offset=OHM] FILE: whether readings and their stated uncertainties are true, resistance
# by resistance. FILE has a line a reading: ohm status reading u ms branch (see `readings` in accuracy.sh).
#
# What is claimed of a reading: it is no number at most once in a hundred times; and the truth is within 2 u of it in 93 to
# 97 % of the cases. Of what a sample of n says about that, only that is held against the daemon which chance brings about in
# less than one case in a million, exactly for counts (binomial), beyond 4.9 standard errors for means. A run of all
# images has less than a thousand such comparisons: it fails without a cause at most once in a thousand times.
#
#   faults    how many readings are no numbers
#   scatter   how many are within 2 u of their own mean: at least 93 %
#   coverage  how many are within 2 u of the truth: at least 93 %; all resistances together at most 97 %
#   mean      their mean error, against its standard error, and what they have in common: the offset's (by_offset at a low
#             resistance) and that of the kinds of discharge, which no reading shows
#
# That is so where each reading has a calibration of its own (calibration=own). Where readings share one, they share its error, and all are
# within 2 u, or none: coverage says nothing, and they have in common as much of u as the scatter leaves (shared). With
# calibrations of their own on a circuit with a defect, which u may state, coverage is as in the first case, the mean as in the second, and
# u may be too large (defect).
BEGIN {
    RARE = 1e-6
    SIGMAS = 4.9
    # Type B: the kernel treats kinds of discharge and of calls differently by up to 100 ns (docs/latency.md), a rectangle, 58 ns
    # each. Through the levers of the equations, c1 1.2 of 2, c2 0.2 of 2, release 3.8 of g_A + g_B = 1303 nF: 0.2 ohm.
    KINDS_OHM = 0.2
}
# P(K <= k) of n cases with the probability p each.
function at_most(k, n, p,    i, log_term, sum) {
    log_term = n * log(1 - p)
    for (i = 0; i <= k; i++) {
        if (log_term > -700) sum += exp(log_term)
        log_term += log((n - i) / (i + 1) * p / (1 - p) + (i == n))
    }
    return sum
}
function at_least(k, n, p) { return at_most(n - k, n, 1 - p) }
function says(what) {
    printf "%s, %s ohm: %s\n", FILENAME, ohm, what
    bad = 1
}
function row(    i, within, covered, mean, sd2, u2, common2, by) {
    if (at_least(all - n, all, 0.01) < RARE) says(sprintf("%d faults in %d readings", all - n, all))
    if (n < 2) return says("no readings")
    mean = sum / n
    for (i = 1; i <= n; i++) {
        sd2 += (r[i] - mean) ^ 2 / (n - 1)
        u2 += u[i] ^ 2 / n
        within += (r[i] - mean) ^ 2 <= 4 * u[i] ^ 2
        covered += (r[i] - ohm) ^ 2 <= 4 * u[i] ^ 2
    }
    if (at_most(within, n, 0.93) < RARE) says(sprintf("%d of %d within 2 u of their mean", within, n))
    if (calibration != "shared") {
        if (at_most(covered, n, 0.93) < RARE) says(sprintf("%d of %d within 2 u of the truth", covered, n))
    }
    if (calibration == "own") {
        # The offset matters as the uncorrected bias does: in full at a short circuit, not at Rc2.
        by = by_offset * (12700 - ohm) / 12700 * (inferred > 0)
        common2 = by ^ 2
    } else {
        # The scatter may be less by three of the standard errors of this estimate.
        common2 = u2 - sd2 / (1 - 2 / (9 * n) + 3 * sqrt(2 / (9 * n))) ^ 3
        if (common2 < 0) common2 = 0
    }
    common2 += KINDS_OHM ^ 2
    if ((mean - ohm) ^ 2 > SIGMAS ^ 2 * (common2 + sd2 / n))
        says(sprintf("mean error %.2f ohm, where %.2f are one standard uncertainty", mean - ohm, sqrt(common2 + sd2 / n)))
    total += n
    total_covered += covered
}
$1 != ohm && ohm { row() }
$1 != ohm { ohm = $1; n = all = sum = inferred = 0 }
{ all++ }
$2 == "ok" { n++; r[n] = $3; u[n] = $4; sum += $3; inferred += $6 == "inferred" }
END {
    row()
    ohm = "all"
    if (calibration == "own" && at_least(total_covered, total, 0.97) < RARE)
        says(sprintf("%d of %d within 2 u: u is too large", total_covered, total))
    exit bad
}
