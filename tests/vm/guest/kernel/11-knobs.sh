# What can be set in the circuit does what its name says.
. /test/lib.sh

since() { tail -n "+$(($1 + 1))" "$discharges"; }
count() { wc -l <"$discharges"; }

# By the crossings that the circuit computed: a stamp can be late, and one of these nine that is 20 us late is worth 13 ohm.
echo "sensor"
n=$(count)
circuit r_mohm 2320000,12700000,5000000,0
tpcm 3 >/dev/null
# 0x100000 is Rc1: 2360 ohm with its pin
r=$(since "$n" | mawk '$2 == "0x100000" { c1 += $8 - $5 } $2 == "0x10000" { x += $8 - $5 } END { printf "%.3f", x / c1 * 2360 - 40 }')
echo "$r"
between "$r" 4999.9 5000.1 # crossings are whole ns: 0.01 ohm

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
between "$((mean - own))" 7640 8360 # 450 draws: 71 is one sigma, and this allows five
between "$deviation" 1250 1750   # 50 is one sigma
circuit late_ns 0
circuit jitter_ns 0

echo "noise of the threshold"
n=$(count)
circuit trigger_pf 500
tpcm 150 >/dev/null
since "$n" | mawk '$2 == "0x100000" { t = ($8 - $5) / 2360; n++; s += t; q += t * t }
    END { printf "%.4f\n", sqrt(q / n - (s / n) ^ 2) }' >spread_nf
cat spread_nf
between "$(cat spread_nf)" 0.35 0.65 # 150 draws: 0.029 is one sigma
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
