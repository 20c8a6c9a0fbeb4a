# For: what the unmodified daemon reads, beside what is true. `. /test/accuracy.sh` after lib.sh.

# Readings left out after the resistor was changed: under way, or planned from the last one.
SETTLING=3

# readings COUNT OHM: so many readings of a resistor, in one line:
# ohm bias_ohm sd_ohm u_ohm ms_per_reading readings inferred faults
readings() {
    circuit r_mohm "2320000,12700000,${2}000,0"
    cermctl record --format csv --count $(($1 + SETTLING)) >last.csv
    mawk -F, -v r="$2" -v skip=$((1 + SETTLING)) '
        NR <= skip { next }
        { ms += $17 / 1000; all++ }
        $5 != "ok" { faults++; next }
        { d = $6 - r; n++; s += d; q += d * d; u += $7 * $7; inferred += $16 == "inferred" }
        END {
            mean = s / n
            printf "%d %.4f %.4f %.4f %.2f %d %d %d\n", r, mean, sqrt(q / n - mean * mean), sqrt(u / n), ms / all, n,
                inferred, faults
        }' last.csv
}

# begin NAME=VALUE...: the daemon with this configuration (see configuration.sh), when it has learned noise and offset.
begin() {
    write_configuration cermd.toml "$@"
    before=$(mawk 'END { print $1 + 0 }' $discharges)
    start_cermd cermd.toml
    cermctl record --raw --seconds 1000 --output tape &
    recorder=$!
    until_true 1000 offset_known || fail "no offset is known"
    until_true 1000 warm || fail "no noise is known"
    kill -INT $recorder
    wait $recorder
    cermctl stats --json >stats.json
    mawk -v before="$before" -f /test/lateness.awk $discharges tape >lateness || { cat lateness; fail "the tape and the circuit disagree"; }
}

warm() { [ "$(stat cycles)" -ge 66 ]; }

# true_offset: mean of all that `begin` saw of the true lateness of calibration discharges, and its standard error, ns.
true_offset() {
    mawk '$1 ~ /^c/ {
        for (i = 3; i <= 5; i += 2) if ($i != "") { n += $2; s += $2 * $i; q += $2 * ($i * $i + $(i + 1) * $(i + 1)) }
    }
    END { mean = s / n; printf "%.1f %.1f\n", mean, sqrt((q / n - mean * mean) / n) }' lateness
}

# column NAME COUNT OHMS: readings of each resistor, as the file NAME.
column() {
    for ohm in $3; do readings "$2" "$ohm"; done >"$1"
    cat "$1"
}

# table TITLE COLUMN...: what `column` has measured, side by side, as Markdown.
table() {
    printf '\n%s\n\n| ohm |' "$1"
    shift
    for name in "$@"; do printf ' %s: bias | sd | u | ms |' "$name"; done
    printf '\n|--:|'
    for name in "$@"; do printf -- '--:|--:|--:|--:|'; done
    echo
    mawk 'FNR == 1 { files++ }
        { ohm[FNR] = $1; cells[FNR, files] = sprintf(" %.2f | %.2f | %.2f | %.1f%s |", $2, $3, $4, $5, $8 ? sprintf(" (%d faults)", $8) : "") }
        END { for (row = 1; row <= FNR; row++) { line = "| " ohm[row] " |"
            for (file = 1; file <= files; file++) line = line cells[row, file]
            print line } }' "$@"
}
