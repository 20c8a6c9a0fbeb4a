# How late a crossing is stamped: from the true crossing to the interrupt, and from there to the stamp; and what lies between a
# release and a sink in one call.
. /test/lib.sh
for round in $(seq 20); do probe v2; done >probed
mawk -v kernel="$(uname -r)" '
    / late / { n++; for (i = 1; i <= NF; i++) if ($i == "late" && $(i - 1) == "irq") { interrupt[n] = $(i + 1) } else if ($i == "late") late[n] = $(i + 1) }
    / gap / { gap[++gaps] = $NF }
    function sort(list, count,    i, j, x) {
        for (i = 2; i <= count; i++) { x = list[i]; for (j = i - 1; j && list[j] > x; j--) list[j + 1] = list[j]; list[j + 1] = x }
    }
    function told(list, count) {
        sort(list, count)
        return sprintf("%.2f / %.2f / %.2f", list[int(count / 2) + 1] / 1e3, list[int(count * 0.95)] / 1e3, list[count] / 1e3)
    }
    END {
        for (i = 1; i <= n; i++) stamp[i] = late[i] - interrupt[i]
        printf "| %s | %s | %s | %s |\n", kernel, told(interrupt, n), told(stamp, n), told(gap, gaps)
    }' probed | tee latency
