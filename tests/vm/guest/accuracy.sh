# For: what the unmodified daemon reads, beside what is true. `. /test/accuracy.sh` after lib.sh.

# Readings left out after the resistor was changed: under way, or planned from the last one.
SETTLING=3
# Progress at which both nodes cross, g_A + g_B of the circuit, F.
G_SUM=1.303013e-6

# readings COUNT OHM: so many readings of a resistor, in one line:
# ohm bias_ohm sd_ohm u_ohm ms_per_reading readings inferred faults within_2u
readings() {
    circuit r_mohm "2320000,12700000,${2}000,0"
    cermctl record --format csv --count $(($1 + SETTLING)) >last.csv
    mawk -F, -v r="$2" -v skip=$((1 + SETTLING)) '
        NR <= skip { next }
        { ms += $17 / 1000; all++ }
        $5 != "ok" { faults++; next }
        {
            d = $6 - r; n++; s += d; q += d * d; u += $7 * $7
            inferred += $16 == "inferred"
            within += d * d <= 4 * $7 * $7
        }
        END {
            mean = s / n
            printf "%d %.4f %.4f %.4f %.2f %d %d %d %d\n", r, mean, sqrt(q / n - mean * mean), sqrt(u / n), ms / all, n,
                inferred, faults, within
        }' last.csv
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

# end: stops the daemon; what it has learned is in stats.json, what is true of all its discharges in `lateness`.
end() {
    cermctl stats --json >stats.json
    kill -INT $recorder
    wait $recorder
    stop_cermd
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
    for ohm in $3; do
        case $ohm in
        100 | 1000) readings $(($2 * 4)) "$ohm" ;;
        *) readings "$2" "$ohm" ;;
        esac
    done >"$1"
    cat "$1"
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

# coverage FILE...: that has to be 93 to 97 %.
coverage() {
    share "$@" | tee covered
    between "$(cut -d' ' -f1 covered)" 93 97
}

# offset_is_true NAME LIMIT: what the daemon has found, against what the circuit exports: within four standard
# uncertainties of both (with fifteen such comparisons, chance fails one suite in a thousand); and the daemon's is less than
# LIMIT ns, or it would say nothing.
offset_is_true() {
    read -r truth u_truth <<-END
	$(true_offset)
	END
    d=$(learned offset_ns) u=$(learned offset_u_ns)
    echo "| $1 | $d | $u | $truth | $u_truth |" | tee -a offsets
    mawk -v d="$d" -v u="$u" -v t="$truth" -v v="$u_truth" -v limit="$2" 'BEGIN {
        exit !((d - t) ^ 2 <= 16 * (u * u + v * v) && u < limit)
    }' ||
        fail "$1: the offset is not the true one"
}

# consistent FILE: the mean reading of each resistor within three standard uncertainties of one reading. Readings that share a
# calibration share its error, so what part of them is within 2 u tells nothing.
consistent() {
    mawk '$2 * $2 > 9 * $4 * $4 { print "not within 3 u:", $0; bad = 1 } END { exit bad }' "$1" ||
        fail "$1: the stated uncertainties are not true"
}

# as_predicted FILE: without correction, -(2 d/(g_A+g_B)) (Rc2-Rx)/(Rc2+Ro), where the switched equation was used. Four
# standard uncertainties of the mean and of the true d.
as_predicted() {
    read -r truth u_truth <<-END
	$(true_offset)
	END
    mawk -v d="$truth" -v u="$u_truth" -v g="$G_SUM" '$7 == $6 {
        by = -2e-9 / g * (12700 - $1) / 12740
        u2 = $3 * $3 / $6 + (by * u) ^ 2
        printf "| %d | %.2f | %.2f | %.2f |\n", $1, $2, sqrt(u2), by * d
        if (($2 - by * d) ^ 2 > 16 * u2) bad = 1
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
