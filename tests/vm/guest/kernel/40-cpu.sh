# What a reading costs the processor, beside the plain C program that takes the same reading (told, not judged); and what
# the service costs at 10 readings a second: below 1 %.
. /test/lib.sh

# cpu: ns that all threads of the daemon, and its measuring thread, have run.
cpu() {
    all=0
    for task in /proc/"$cermd"/task/*; do
        read -r ns _ <"$task/schedstat"
        all=$((all + ns))
        [ "$(cat "$task/comm")" != cermd-measure ] || measuring=$ns
    done
    echo $all $measuring
}

# cost SECONDS: readings, ns of all threads, ns of the measuring thread.
cost() {
    from="$(stat readings) $(cpu)"
    sleep "$1"
    to="$(stat readings) $(cpu)"
    echo "$from $to" | mawk '{ print $4 - $1, $5 - $2, $6 - $3 }'
}

plain() { tpcm "$@" | sed -n 's/.*cpu_us_per_reading \([0-9.]*\).*/\1/p'; }
plain_us=$(plain 200)
checked_us=$(plain 200 checked)
write_configuration cermd.toml method=tpcm "offset=0 us"
start_cermd cermd.toml
sleep 5
cost 20 >free
stop_cermd
write_configuration cermd.toml method=cerm rate=10
start_cermd cermd.toml
until_true 1000 offset_known
cost 60 >ten
stop_cermd

{
    echo "## Linux $(uname -r)"
    read -r n all measuring <free
    mawk -v plain="$plain_us" -v checked="$checked_us" -v n="$n" -v all="$all" -v m="$measuring" 'BEGIN {
        print "\n| a TPCM reading, three discharges | us | beside the C program |\n|---|--:|--:|"
        printf "| C program | %.0f | 1 |\n", plain
        printf "| C program with the checks of cermd | %.0f | %.2f |\n", checked, checked / plain
        printf "| cermd, measuring | %.0f | %.2f |\n", m / n / 1e3, m / n / 1e3 / plain
        printf "| cermd, publishing | %.0f | %.2f |\n", (all - m) / n / 1e3, (all - m) / n / 1e3 / plain
    }'
    read -r n all measuring <ten
    mawk -v all="$all" 'BEGIN { printf "\nCERM, 10 readings a second: %.2f %% of the processor.\n", all / 6e8 }'
} >cpu.md
cat cpu.md
mawk -v all="$all" 'BEGIN { exit !(all / 6e8 < 1) }' || fail "too dear at 10 readings a second"
