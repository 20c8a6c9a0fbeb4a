# lateness.awk -v before=N DISCHARGES TAPE: how much later than the truth the daemon has a crossing, from the start that it
# assumes: (stamp - assumed start) - (true crossing - true start), ns. This is what the offset d stands for.
# DISCHARGES: what the circuit exports; TAPE: what the daemon measured; N: discharges before those of the daemon.
# Prints for each kind of discharge: kind, number, mean and standard deviation for A, for B; for switched ones also of the
# instants of release and sinking.
function field(name) {
    if (!match($0, "\"" name "\":[^,}]*")) return ""
    return substr($0, RSTART + length(name) + 3, RLENGTH - length(name) - 3)
}
# No crossing is so much later than the truth, ns.
function is_far(late) { return late < -100000 || late > 100000 }
function add(kind, node, late) {
    n[kind, node]++
    sum[kind, node] += late
    square[kind, node] += late * late
}
function told(kind, node,    mean, count) {
    count = n[kind, node]
    if (!count) return ""
    mean = sum[kind, node] / count
    return sprintf(" %.1f %.1f", mean, sqrt(square[kind, node] / count - mean * mean))
}
FNR == NR { if (!oldest) oldest = $1; first[$1] = $2; start[$1] = $5; release[$1] = $6; sunk[$1] = $7; a[$1] = $8; b[$1] = $9; next }
/"DISCHARGE"/ {
    seq = field("seq") + before
    # The circuit remembers the last discharges only.
    if (seq < oldest) next
    through = field("through")
    gsub("\"", "", through)
    sink["c1"] = "0x100000"; sink["c2"] = "0x200000"; sink["x"] = "0x10000"
    # Not on the tape are discharges that ended in a fault, and those that only drain after it: they are of another resistor, did
    # not cross, or took another time.
    for (skipped = 0; first[seq] != sink[through] || !a[seq] || is_far(field("a_ns") - (a[seq] - start[seq])); skipped++) {
        if (skipped == 5) {
            print "discharge " seq " is through " first[seq] ", not " through
            exit failed = 1
        }
        seq++
        before++
    }
    if (/"held":true/) next
    kind = through (/"switch"/ ? "-switched" : "")
    kinds[kind] = 1
    add(kind, "a", field("a_ns") - (a[seq] - start[seq]))
    if (field("b_ns") != "") add(kind, "b", field("b_ns") - (b[seq] - start[seq]))
    if (!/"switch"/) next
    match($0, /"at_ns":[0-9.]*/)
    add(kind, "release", substr($0, RSTART + 8, RLENGTH - 8) - (release[seq] - start[seq]))
    match($0, /"on_ns":[0-9.]*/)
    add(kind, "sink", substr($0, RSTART + 8, RLENGTH - 8) - (sunk[seq] - start[seq]))
}
END {
    if (failed) exit 1
    for (kind in kinds) print kind, n[kind, "a"] told(kind, "a") told(kind, "b") told(kind, "release") told(kind, "sink")
}
