# For: what the unmodified daemon reads, beside what is true. `. /test/accuracy.sh` after lib.sh.

# Readings left out after the resistor was changed: under way, or planned from the last one.
SETTLING=3
# Rc1 and Rc2 as they are in the circuit, milliohm.
KNOWN=2320000,12700000
# Progress at which both nodes cross, g_A + g_B of the circuit, F.
G_SUM=1.303013e-6

# readings COUNT OHM NAME: so many readings of a resistor, added to NAME.readings (a line each: ohm status reading u ms branch),
# and in one line:
# ohm bias_ohm sd_ohm u_ohm ms_per_reading readings inferred faults within_2u
# with the median of u: the few that say that they move, because a stamp was late, have a much larger one.
readings() {
    circuit r_mohm "$KNOWN,${2}000,0"
    cermctl record --format csv --count $(($1 + SETTLING)) |
        mawk -F, -v r="$2" -v skip=$((1 + SETTLING)) 'NR > skip {
            print r, $5, $6 == "" ? "-" : $6, $7 == "" ? "-" : $7, $19 / 1000, $18 == "" ? "-" : $18
        }' >last
    cat last >>"$3.readings"
    sort -n -k 4 last | mawk '{ r = $1; ms += $5; all++ }
        $2 != "ok" { faults++; next }
        {
            d = $3 - r; n++; s += d; q += d * d; u[n] = $4
            inferred += $6 == "inferred"
            within += d * d <= 4 * $4 * $4
        }
        END {
            if (n) mean = s / n
            if (n) printf "%d %.4f %.4f %.4f %.2f %d %d %d %d\n", r, mean, sqrt(q / n - mean * mean), u[int(n / 2) + 1], ms / all, n,
                inferred, faults, within
            else printf "%d nan nan nan %.2f 0 0 %d 0\n", r, ms / all, faults
        }' last
}

# begin NAME=VALUE...: the daemon with this configuration (see configuration.sh), when it has learned noise and offset.
begin() {
    write_configuration cermd.toml "$@"
    before=$(mawk 'END { print $1 + 0 }' $discharges)
    start_cermd cermd.toml
    cermctl record --raw --seconds 10000 --output tape &
    recorder=$!
    until_true 1000 offset_known || fail "no offset is known"
    until_true 1000 warm || fail "no noise is known"
}

warm() { [ "$(stat cycles)" -ge 66 ]; }

# finish: stops the daemon; what it has learned is in stats.json, its tape in `tape`.
finish() {
    cermctl stats --json >stats.json
    kill -INT $recorder
    wait $recorder
    stop_cermd
}

# end: the same, and what is true of all its discharges is in `lateness`.
end() {
    finish
    mawk -v before="$before" -f /test/lateness.awk $discharges tape >lateness || { cat lateness; fail "the tape and the circuit disagree"; }
    rm tape
}

# learned NAME: a number of stats.json.
learned() { sed -n "s/.*\"$1\":\([^,}]*\).*/\1/p" stats.json; }

# true_offset: mean of the true lateness of all calibration discharges since `begin`, and its standard error, ns.
true_offset() {
    mawk '$1 ~ /^c/ {
        for (i = 3; i <= 5; i += 2) if ($i != "") { n += $2; s += $2 * $i; q += $2 * ($i * $i + $(i + 1) * $(i + 1)) }
    }
    END { mean = s / n; printf "%.1f %.1f\n", mean, sqrt((q / n - mean * mean) / n) }' lateness
}

# column NAME COUNT OHMS: readings of each resistor, as the file NAME; four times as many where there is a limit of an ohm.
column() {
    rm -f "$1.readings"
    for ohm in $3; do
        case $ohm in
        100 | 1000) readings $(($2 * 4)) "$ohm" "$1" ;;
        *) readings "$2" "$ohm" "$1" ;;
        esac
    done >"$1"
    cat "$1"
}

# judge NAME own|shared|defect: see judge.awk. The offset's share is by the u that the daemon states of it.
judge() {
    case $1 in tpcm | tcdic) by_offset=0 ;; *) by_offset=$(mawk -v u="$(learned offset_u_ns)" -v g="$G_SUM" 'BEGIN { print 2e-9 * u / g }') ;; esac
    echo "$1 $2 $by_offset" >>judged
    mawk -v calibration="$2" -v by_offset="$by_offset" -f /test/judge.awk "$1.readings"
}

# judged NAME own|shared: fails if the readings are not what is claimed of them.
judged() { judge "$1" "$2" || fail "$1: the readings or their uncertainties are not true"; }

# judge_sees MUTANT: whether the judge refuses what it has found true, as a daemon with this fault would give it: each column with
# calibrations of its own for itself, the others for their faults. Where u is mostly what the readings share, half of it or twice as
# much need not show in them; whether it does stands in `mutants`.
judge_sees() {
    sort -u judged | while read -r name calibration by_offset; do
        mawk -v mutant="$1" -f /test/mutate.awk "$name.readings" >mutant
        seen=yes
        mawk -v calibration="$calibration" -v by_offset="$by_offset" -f /test/judge.awk mutant >why && seen=no
        echo "$1 $name $calibration $seen $(head -n 1 why)"
    done | tee -a mutants
    rm mutant why
    mawk -v mutant="$1" '$1 == mutant && $4 == "no" && ($3 == "own" || mutant == "faulty") { bad = 1 } END { exit bad }' mutants ||
        fail "the judge does not see that the daemon is $1"
}

# within_limits FILE: 1 ohm at 100 ohm, 0.1 % from 1 kohm.
within_limits() {
    mawk '{ bias = $2 < 0 ? -$2 : $2 }
        $1 == 100 && bias >= 1 || $1 >= 1000 && bias >= $1 / 1000 { print "over the limit:", $0; bad = 1 }
        END { exit bad }' "$1" || fail "$1: biased"
}

# share FILE...: how many readings are within two of their standard uncertainties.
share() {
    mawk '{ n += $6; within += $9 } END { printf "%.1f %% of %d readings are within 2 u of the truth\n", 100 * within / n, n }' "$@"
}

# offset_is_true NAME LIMIT: what the daemon has found, against what the circuit exports: within 4.9 standard uncertainties of
# both and of the kinds of discharge, as in judge.awk; and the daemon's is less than LIMIT ns, or it would say nothing.
offset_is_true() {
    read -r truth u_truth <<-END
	$(true_offset)
	END
    d=$(learned offset_ns) u=$(learned offset_u_ns)
    printf '| %s | %.0f | %.0f | %.0f | %.0f |\n' "$1" "$d" "$u" "$truth" "$u_truth" | tee -a offsets
    mawk -v d="$d" -v u="$u" -v t="$truth" -v v="$u_truth" -v limit="$2" 'BEGIN {
        exit !((d - t) ^ 2 <= 4.9 ^ 2 * (u * u + v * v + 58 ^ 2) && u < limit)
    }' ||
        fail "$1: the offset is not the true one"
}

# as_predicted FILE: without correction, -(2 d/(g_A+g_B)) (Rc2-Rx)/(Rc2+Ro), where the switched equation was used. Within
# 4.9 standard uncertainties: of the mean, of the true d, and the 0.2 ohm of the kinds of discharge (see judge.awk), as no kind is late by
# the mean d.
as_predicted() {
    read -r truth u_truth <<-END
	$(true_offset)
	END
    mawk -v d="$truth" -v u="$u_truth" -v g="$G_SUM" '$7 == $6 {
        by = -2e-9 / g * (12700 - $1) / 12740
        u2 = $3 * $3 / $6 + (by * u) ^ 2 + 0.2 ^ 2
        printf "| %d | %.2f | %.2f | %.2f |\n", $1, $2, sqrt(u2), by * d
        if (($2 - by * d) ^ 2 > 4.9 ^ 2 * u2) bad = 1
        n++
    }
    END { exit bad || !n }' "$1" >"$1.txt" || status=$?
    cat "$1.txt"
    [ -z "${status-}" ] || fail "the bias without correction is not the predicted one"
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
