# What can be set in the circuit does what its name says.
. /test/lib.sh

ohms() { tpcm "$1" | sed -n 's/.*mean_ohm \([^ ]*\) .*/\1/p'; }
since() { tail -n "+$(($1 + 1))" "$discharges"; }
count() { wc -l <"$discharges"; }

echo "sensor"
circuit r_mohm 2320000,12700000,5000000,0
r=$(ohms 3)
echo "$r"
between "$r" 4996 5004 # a difference of 2 us in lateness is 2 us / g_A = 4 ohm

echo "lateness and its noise"
n=$(count)
tpcm 150 >/dev/null
since "$n" | irq_lateness >lateness
cat lateness
read -r own deviation <lateness
between "$own" 500 3000 # the kernel's own
between "$deviation" 0 1000
n=$(count)
circuit late_ns 8000
circuit jitter_ns 1500
tpcm 150 >/dev/null
since "$n" | irq_lateness >lateness
cat lateness
read -r mean deviation <lateness
between "$((mean - own))" 7750 8250 # 450 draws: 71 is one sigma
between "$deviation" 1350 1650   # 50 is one sigma
circuit late_ns 0
circuit jitter_ns 0

echo "noise of the threshold"
n=$(count)
circuit trigger_pf 500
tpcm 150 >/dev/null
# 0x100000 is Rc1: 2360 ohm with its pin
since "$n" | mawk '$2 == "0x100000" { t = ($8 - $5) / 2360; n++; s += t; q += t * t }
    END { printf "%.4f\n", sqrt(q / n - (s / n) ^ 2) }' >spread_nf
cat spread_nf
between "$(cat spread_nf)" 0.4 0.6
circuit trigger_pf 0

echo "faults"
circuit swallow 1
tpcm 1 && fail "an interrupt was not swallowed"
circuit cut 0x20 # the wire of sense line A
tpcm 1 && fail "the cut wire gave an edge"
circuit cut 0
circuit r_mohm 0,12700000,5000000,0
tpcm 1 && fail "the missing resistor discharged"
circuit r_mohm 2320000,12700000,1000000,0
[ "$(cat $parameters/conflicts)" = 0 ] || fail "conflicts before there was one"
gpioset --chip "$(chip)" --toggle 1ms,0 GPIO13=1 GPIO19=1 GPIO20=0
[ "$(cat $parameters/conflicts)" -gt 0 ] || fail "a conflict was not counted"
circuit conflicts 0
