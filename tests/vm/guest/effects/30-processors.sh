# Two processors. The emulator runs them by turns, and what one of them does takes time from the other, as a hypervisor or a
# processor that stops for its firmware would: between two instructions of the daemon, or before an interrupt. Told, and not judged.
. /test/lib.sh
. /test/accuracy.sh
[ "$(grep -c '^processor' /proc/cpuinfo)" = 2 ] || exit 77
circuit late_ns 6000
circuit jitter_ns 1500
{
    printf '|  | method | 100 ohm: bias (u) | 1000 ohm: bias (u) | 5000 ohm: bias (u) | 16200 ohm: bias (u) |'
    printf ' within 2 u | no number | the judge |\n|---|---|--:|--:|--:|--:|--:|--:|---|\n'
} >effects.md
for method in cerm tracked; do
    begin method=$method
    column $method 60 "100 1000 5000 16200"
    finish
    rm tape
    judge $method $([ $method = cerm ] && echo defect || echo shared) && verdict=holds || verdict="**fails**"
    mawk -v method=$method -v verdict="$verdict" '
        { row = row sprintf(" %.2f (%.2f) |", $2, $4); n += $6; within += $9; faults += $8 }
        END { printf "| two processors by turns | %s |%s %.0f %% | %d of %d | %s |\n", method, row, n ? 100 * within / n : 0, faults, n + faults, verdict }
    ' $method | tee -a effects.md
done
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"
