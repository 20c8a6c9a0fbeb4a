# The kernel's tick comes every 4 ms (CONFIG_HZ=250 of Debian's kernels), at whole multiples of that, and takes 9 us here, 30 us where it
# has more to do. Discharges begin so that neither their calls nor the falls of their nodes meet one. When a node falls that a slow resistor
# finishes after a late switch, nobody knows to some microseconds: at 100 ohm, and of cerm, what is left is told.
. /test/lib.sh
. /test/accuracy.sh
circuit late_ns 6000
circuit jitter_ns 1500
KNOWN=470000,12700000
# met OHM METHOD SECONDS: how many instants that count meet a tick, and of how many.
met() {
    circuit r_mohm "$KNOWN,${1}000,0"
    write_configuration cermd.toml "r_c1=470 ohm" "method=$2"
    start_cermd cermd.toml
    until_true 200 offset_known || fail "no offset is known"
    before=$(mawk 'END { print $1 + 0 }' $discharges)
    sleep "$3"
    # Moves of lines: one whose call a tick has interrupted comes just after it. Falls of A and B, 6 us before their interrupts; of B where
    # one has told it.
    mawk -v before="$before" '
        function count(at, from, to) { if (at) { all++; phase = (at - from) % 4000000; met += phase < to - from } }
        $1 > before && $10 {
            count($5, 0, 20000)
            if ($7) { count($6, 0, 20000); count($7, 0, 20000) }
            count($8, -6000, 9000)
            if ($11) count($9, -6000, 9000)
        } END { print met + 0, all }' $discharges >counted
    stop_cermd
    read -r m a <counted
    echo "$1 ohm, $2: $m of $a instants meet a tick, by chance it would be $((a / 230))"
}
met 100 tracked 6
met 1000 cerm 6
all=0 of_all=0
for ohm in 1000 5000 16200; do
    met $ohm tracked 10
    all=$((all + a)) of_all=$((of_all + m))
done
[ "$all" -ge 15000 ] || fail "there were only $all instants"
[ $((of_all * 1500)) -le "$all" ] || fail "$of_all of $all instants meet a tick"
