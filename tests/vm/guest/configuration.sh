# A configuration of cermd for the circuit as the module makes it: `write_configuration FILE [NAME=VALUE...]`.
# Names: backend, method, calibration, offset ("auto" or a duration), rate (readings per second), idle (true, false), t_l, chargers
# (yes; no: the sense lines charge, as in the paper), c_a, c_b, c (one capacitor instead), r_c1, socket.
write_configuration() (
    file=$1 backend=chardev method=cerm calibration= offset=auto rate= idle= t_l= chargers=yes c_a="2.2 uF" c_b="680 nF" c= r_c1="2.32 kohm" socket=/run/cermd/cermd.sock
    shift
    for setting in "$@"; do eval "${setting%%=*}=\${setting#*=}"; done
    {
        echo "[circuit]"
        if [ -n "$c" ]; then printf 'kind = "one-capacitor"\nc = "%s"\n' "$c"; else
            printf 'kind = "two-capacitor"\nc-a = "%s"\nc-b = "%s"\n' "$c_a" "$c_b"
        fi
        printf 'r-c1 = "%s"\nr-c2 = "12.7 kohm"\n' "$r_c1"
        cat <<-TOML

	[gpio]
	backend = "$backend"
	chip = "cermd-rc"
	sense-a = "GPIO5"
	sink-c1 = "GPIO20"
	sink-c2 = "GPIO21"
	TOML
        [ -n "$c" ] || echo 'sense-b = "GPIO6"'
        [ $chargers = no ] || echo 'charge-a = "GPIO13"'
        [ $chargers = no ] || [ -n "$c" ] || echo 'charge-b = "GPIO19"'
        printf '\n[measure]\nmethod = "%s"\noffset = "%s"\n' "$method" "$offset"
        [ -z "$calibration" ] || echo "calibration = \"$calibration\""
        [ -z "$t_l" ] || echo "t-l = \"$t_l\""
        [ -z "$rate" ] || echo "rate-hz = $rate"
        [ -z "$idle" ] || echo "idle = $idle"
        printf '\n[[channel]]\nid = "x"\nsink = "GPIO16"\nzero-ohm = 0.0\nscale = 1.0\n'
        printf '\n[server]\nsocket = "%s"\n' "$socket"
        printf '\n[realtime]\npriority = 40\nlock-memory = true\ncpu = 0\ndma-latency = true\n'
    } >"$file"
)
