# A configuration of cermd for the circuit as the module makes it: `write_configuration FILE [NAME=VALUE...]`.
# Names: backend, method, calibration, offset ("auto" or a duration), rate (readings per second), t_l, chargers (yes; no:
# the sense lines charge, as in the paper), c_a, c_b, socket.
write_configuration() (
    file=$1 backend=chardev method=cerm calibration= offset=auto rate= t_l= chargers=yes c_a="2.2 uF" c_b="680 nF" socket=/run/cermd/cermd.sock
    shift
    for setting in "$@"; do eval "${setting%%=*}=\${setting#*=}"; done
    {
        cat <<-TOML
	[circuit]
	kind = "two-capacitor"
	c-a = "$c_a"
	c-b = "$c_b"
	r-c1 = "2.32 kohm"
	r-c2 = "12.7 kohm"

	[gpio]
	backend = "$backend"
	chip = "cermd-rc"
	sense-a = "GPIO5"
	sense-b = "GPIO6"
	sink-c1 = "GPIO20"
	sink-c2 = "GPIO21"
	TOML
        [ $chargers = no ] || printf 'charge-a = "GPIO13"\ncharge-b = "GPIO19"\n'
        printf '\n[measure]\nmethod = "%s"\noffset = "%s"\n' "$method" "$offset"
        [ -z "$calibration" ] || echo "calibration = \"$calibration\""
        [ -z "$t_l" ] || echo "t-l = \"$t_l\""
        [ -z "$rate" ] || echo "rate-hz = $rate"
        printf '\n[[channel]]\nid = "x"\nsink = "GPIO16"\nzero-ohm = 0.0\nscale = 1.0\n'
        printf '\n[server]\nsocket = "%s"\n' "$socket"
        printf '\n[realtime]\npriority = 40\nlock-memory = true\ncpu = 0\ndma-latency = true\n'
    } >"$file"
)
