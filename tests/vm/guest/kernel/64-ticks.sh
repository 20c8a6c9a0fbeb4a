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
    # Start, release and sink of a switch, and the falls of A and B where an interrupt has told them; 0: there was none.
    mawk -v before="$before" '$1 > before && $10 {
        n = split($5 " " ($7 ? $6 : 0) " " $7 " " $8 " " ($11 ? $9 : 0), at, " ")
        for (i = 1; i <= n; i++) if (at[i]) { all++; phase = at[i] % 4000000; met += phase < 9000 || phase > 3999000 }
    } END { print met + 0, all }' $discharges >counted
    stop_cermd
    read -r m a <counted
    echo "$1 ohm, $2: $m of $a instants meet a tick, by chance it would be $((a / 400))"
}
met 100 tracked 6
met 1000 cerm 6
all=0 of_all=0
for ohm in 1000 5000 16200; do
    met $ohm tracked 10
    all=$((all + a)) of_all=$((of_all + m))
done
[ "$all" -ge 15000 ] || fail "there were only $all instants"
[ $((of_all * 3000)) -le "$all" ] || fail "$of_all of $all instants meet a tick"
