# Helpers for guest tests: `. /test/lib.sh`.
. /test/configuration.sh
parameters=/sys/module/gpio_cermd/parameters
discharges=/sys/kernel/debug/gpio-cermd/discharges

# circuit NAME VALUE: a parameter of the circuit, e.g. circuit r_mohm 2320000,12700000,100000,0
circuit() { echo "$2" >"$parameters/$1"; }

fail() {
    echo "$*" >&2
    exit 1
}

# as_user COMMAND...: without any right of root.
as_user() {
    # busybox's setpriv changes no identity, its su does.
    if [ -e /usr/bin/busybox ]; then su user -c "$*"; else setpriv --reuid=1000 --regid=1000 --clear-groups "$@"; fi
}

# irq_lateness: mean and standard deviation of crossing A to its interrupt, ns, over the discharges that standard input
# lists. One in a thousand is late by 20 us because the kernel has something else to do: those far from the median are left
# out.
irq_lateness() {
    mawk '$10 { print $10 - $8 }' | sort -n | mawk '{ late[NR] = $1 }
        END {
            median = late[int(NR / 2) + 1]
            far = 5000 + 5 * (late[int(NR * 0.84) + 1] - median)
            for (i = 1; i <= NR; i++) if ((late[i] - median) ^ 2 < far ^ 2) { n++; s += late[i]; q += late[i] ^ 2 }
            if (n < 0.98 * NR) { print NR - n " of " NR " are far from the median"; exit 1 }
            printf "%.0f %.0f\n", s / n, sqrt(q / n - (s / n) ^ 2)
        }'
}

# between VALUE LOW HIGH: fails unless LOW <= VALUE <= HIGH.
between() {
    mawk -v v="$1" -v l="$2" -v h="$3" 'BEGIN { exit !(v >= l && v <= h) }' || fail "$1 is not within $2 and $3"
}

# chip: the name of the circuit's chip; nothing if there is none.
chip() { gpiodetect | sed -n 's/ \[cermd-rc\].*//p'; }

# start_cermd FILE: the daemon with a configuration; returns when it serves. Sets $cermd, its process; its words go to
# cermd.log.
start_cermd() {
    mkdir -p /run/cermd
    cermd --config "$1" 2>>cermd.log &
    cermd=$!
    trap 'kill -KILL $cermd 2>/dev/null || true' EXIT
    export CERMD_SOCKET
    CERMD_SOCKET=$(sed -n 's/^socket = "\(.*\)"/\1/p' "$1")
    until_true 100 cermctl get || fail "cermd does not serve"
}

stop_cermd() {
    kill "$cermd"
    trap - EXIT
    wait "$cermd" || fail "cermd ended with exit status $?"
}

# until_true TIMES COMMAND...: tries it so many times, 50 ms apart, without its words.
until_true() {
    tries=$1
    shift
    while ! "$@" >/dev/null 2>&1; do
        tries=$((tries - 1))
        [ $tries -gt 0 ] || return 1
        sleep 0.05
    done
}

# stat NAME: a number, word or flag of the daemon's STATS.
# The first of that name: each channel has counters, too.
stat() { cermctl stats --json | grep -o "\"$1\":\"*[^,\"}]*" | head -n 1 | sed 's/.*:"*//'; }

# settled: a reading that is a number and has settled, in the file `reading`; before that, the uncertainty is a wide prior.
settled() { cermctl get --json | grep '"status":"ok"' | grep -v '"settling":true' >reading; }

offset_known() { [ "$(stat offset_known)" = true ]; }

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

# cost SECONDS: readings that are numbers (a fault may be cheap), ns of all threads, ns of the measuring thread.
cost() {
    from="$(stat ok) $(cpu)"
    sleep "$1"
    to="$(stat ok) $(cpu)"
    echo "$from $to" | mawk '{ print $4 - $1, $5 - $2, $6 - $3 }'
}
