# How fast the daemon reads by its default method, what that costs, and what it costs at 10 readings a second: with all discharges
# that fit in, whose mean is published, and with as few as they need. Rc1 is 470 ohm; two capacitors, 2.2 uF and 680 nF, and one of 470 nF.
. /test/lib.sh
. /test/accuracy.sh
ohms="100 1000 16200"
KNOWN=470000,12700000

# told NAME OHM SECONDS COUNT CONFIGURATION...: a row of the table, measured over so many seconds, its error from so many readings.
told() {
    name=$1 ohm=$2 seconds=$3 count=$4
    shift 4
    circuit r_mohm "$KNOWN,${ohm}000,0"
    write_configuration cermd.toml "r_c1=470 ohm" "$@"
    start_cermd cermd.toml
    until_true 200 steady || fail "it stays unsettled: $(cermctl stats --json)"
    before=$(mawk 'END { print $1 + 0 }' $discharges)
    cost "$seconds" >spent
    # The last one is still under way.
    mawk -v before="$before" '$1 > before { n++; lost += is_lost; is_lost = !$10; late += $10 && $10 - $8 > 15500 }
        END { print n - 1, late + 0, lost + 0 }' $discharges >edges
    rows=$((${rows-0} + 1))
    readings "$count" "$ohm" row$rows >error
    cermctl stats --json
    stop_cermd
    cat spent edges error | tr '\n' ' ' | mawk -v name="$name" -v s="$seconds" '{
        printf "| %s | %d | %.0f | %.2f | %.2f | %.2f | %.0f | %.2f | %d of %d, %d |\n",
            name, $7, $1 / s, $8, $9, $10, $2 / $1 / 1e3, $2 / s / 1e7, $5, $4, $6
    }' | tee -a rows
}
# Noise is known: no uncertainty is a prior any more.
steady() { cermctl get --json | grep '"status":"ok"' | grep -v settling; }

# c_program OHM: the plain one takes three discharges.
c_program() {
    circuit r_mohm "2320000,12700000,${1}000,0"
    tpcm 100 | mawk -v ohm="$1" 'NR == 1 { printf "| C program | %d | %.0f |  |  |  | %.0f | %.2f |  |\n", ohm, 1e6 / $8, $6, 100 * $6 / $8 }' | tee -a rows
}

circuit late_ns 6000
circuit jitter_ns 1500
for ohm in $ohms; do c_program "$ohm"; done
for ohm in $ohms; do told "cerm" "$ohm" 5 60 method=cerm; done
for ohm in $ohms; do told "tracked" "$ohm" 5 300 method=tracked; done
for ohm in $ohms; do told "the same, 10 Hz" "$ohm" 10 20 method=tracked rate=10; done
for ohm in $ohms; do told "the same, 10 Hz and idle" "$ohm" 20 60 method=tracked rate=10 idle=true; done
circuit g_pf 437834,0
circuit c_pf 470000,0
for ohm in $ohms; do told "tracked, one capacitor" "$ohm" 5 300 method=tracked "c=470 nF"; done
{
    printf '\n### Readings a second, by the default method\n\n'
    printf '|  | ohm | readings a second | bias, ohm | sd | u | us a reading | %% of the processor | A late of discharges, lost |\n'
    printf '|---|--:|--:|--:|--:|--:|--:|--:|--:|\n'
    cat rows
} >cpu.md
cat cpu.md
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"
