# What a reading costs the processor, beside the plain C program that takes the same reading: at most as much where the
# calibration is followed, with a client that watches as without, which is judged; with a calibration of its own for each
# reading it is told.
# And what the service costs at 10 readings a second, idle in between: below 1 %.
. /test/lib.sh

plain() { tpcm "$@" | sed -n 's/.*cpu_us_per_reading \([0-9.]*\).*/\1/p'; }
# reading NAME CALIBRATION: what a TPCM reading costs, into the file NAME, and with a client that watches, into NAME.watched.
reading() {
    write_configuration cermd.toml method=tpcm calibration="$2" "offset=0 us"
    start_cermd cermd.toml
    sleep 5
    cost 20 >"$1"
    cermctl watch >watched.log &
    watch=$!
    sleep 1
    cost 20 >"$1.watched"
    kill $watch
    stop_cermd
}

# Stamps as late as those of a board: how often the calibration is taken depends on their scatter.
circuit late_ns 6000
circuit jitter_ns 1500
plain_us=$(plain 200)
checked_us=$(plain 200 checked)
reading each each-reading
reading tracked tracked
write_configuration cermd.toml method=cerm rate=10 idle=true
start_cermd cermd.toml
until_true 1000 offset_known
cost 60 >ten
stop_cermd

# row NAME WHAT: a row of the table from a file of that name.
row() {
    read -r n all measuring <"$1"
    mawk -v plain="$plain_us" -v what="$2" -v n="$n" -v all="$all" -v m="$measuring" 'BEGIN {
        printf "| %s | %.0f | %.0f | %.0f | %.2f |\n", what, n / 20, m / n / 1e3, all / n / 1e3, all / n / 1e3 / plain
    }'
}

{
    echo "## Linux $(uname -r)"
    printf '\n| a TPCM reading | a second | measuring, us | all threads, us | beside the C program |\n|---|--:|--:|--:|--:|\n'
    printf '| C program | | | %.0f | 1 |\n' "$plain_us"
    mawk -v plain="$plain_us" -v us="$checked_us" 'BEGIN { printf "| C program with the checks of cermd | | | %.0f | %.2f |\n", us, us / plain }'
    row tracked "cermd, calibration followed"
    row tracked.watched "the same, with a client that watches"
    row each "cermd, a calibration for each reading"
    row each.watched "the same, with a client that watches"
    read -r n all measuring <ten
    mawk -v all="$all" 'BEGIN { printf "\nCERM, 10 readings a second, idle in between: %.2f %% of the processor.\n", all / 6e8 }'
} >cpu.md
cat cpu.md
mawk -v all="$all" 'BEGIN { exit !(all / 6e8 < 1) }' || fail "too dear at 10 readings a second"
for file in tracked tracked.watched; do
    read -r n all measuring <$file
    mawk -v all="$all" -v n="$n" -v plain="$plain_us" 'BEGIN { exit !(all / n / 1e3 <= plain) }' ||
        fail "$file: a reading costs more than that of the C program"
done
