# The kernel's tick comes every 4 ms (CONFIG_HZ=250 of Debian's kernels), at whole multiples of that, and takes 9 us here, 30 us where it
# has more to do. Discharges begin so that neither their calls nor the falls of their nodes meet one: by chance one instant in 400 would. Some
# do, as nobody knows to some microseconds when a node falls that another resistor finishes.
. /test/lib.sh
. /test/accuracy.sh
circuit late_ns 6000
circuit jitter_ns 1500
KNOWN=470000,12700000
met=0 all=0
for case in "100 tracked" "1000 tracked" "5000 tracked" "16200 tracked" "1000 cerm"; do
    set -- $case
    circuit r_mohm "$KNOWN,${1}000,0"
    write_configuration cermd.toml "r_c1=470 ohm" "method=$2"
    start_cermd cermd.toml
    until_true 200 offset_known || fail "no offset is known"
    before=$(mawk 'END { print $1 + 0 }' $discharges)
    sleep 6
    # Start, release and sink of a switch, and the falls of A and B where an interrupt has told them; 0: there was none.
    mawk -v before="$before" '$1 > before && $10 {
        n = split($5 " " ($7 ? $6 : 0) " " $7 " " $8 " " ($11 ? $9 : 0), at, " ")
        for (i = 1; i <= n; i++) if (at[i]) { all++; phase = at[i] % 4000000; met += phase < 9000 || phase > 3999000 }
    } END { print met + 0, all }' $discharges >counted
    stop_cermd
    read -r m a <counted
    echo "$1 ohm, $2: $m of $a instants meet a tick"
    met=$((met + m)) all=$((all + a))
done
echo "$met of $all, by chance it would be $((all / 400))"
[ "$all" -ge 8000 ] || fail "there were only $all instants"
[ $((met * 800)) -le "$all" ] || fail "$met of $all instants meet a tick"
