# Helpers for guest tests: `. /test/lib.sh`.
parameters=/sys/module/gpio_cermd/parameters
discharges=/sys/kernel/debug/gpio-cermd/discharges

# circuit NAME VALUE: a parameter of the circuit, e.g. circuit r_mohm 2320000,12700000,100000,0
circuit() { echo "$2" >"$parameters/$1"; }

fail() {
    echo "$*" >&2
    exit 1
}
