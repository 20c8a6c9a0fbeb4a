# Helpers for guest tests: `. /test/lib.sh`.
parameters=/sys/module/gpio_cermd/parameters
discharges=/sys/kernel/debug/gpio-cermd/discharges

# circuit NAME VALUE: a parameter of the circuit, e.g. circuit r_mohm 2320000,12700000,100000,0
circuit() { echo "$2" >"$parameters/$1"; }

fail() {
    echo "$*" >&2
    exit 1
}

# as_user COMMAND...: without any right of root.
as_user() { setpriv --reuid=1000 --regid=1000 --clear-groups "$@"; }

# irq_lateness: mean and standard deviation of crossing A to its interrupt, ns, over the discharges that standard input
# lists.
irq_lateness() {
    mawk '$10 { d = $10 - $8; n++; s += d; q += d * d } END { printf "%.0f %.0f\n", s / n, sqrt(q / n - (s / n) ^ 2) }'
}

# between VALUE LOW HIGH: fails unless LOW <= VALUE <= HIGH.
between() {
    mawk -v v="$1" -v l="$2" -v h="$3" 'BEGIN { exit !(v >= l && v <= h) }' || fail "$1 is not within $2 and $3"
}

# chip: the name of the circuit's chip; nothing if there is none.
chip() { gpiodetect | sed -n 's/ \[cermd-rc\].*//p'; }
