# SIGKILL at any instant of a cycle: nothing drives after the cleaner has run, the next daemon serves, no client has half a
# line.
. /test/lib.sh
outputs=/sys/kernel/debug/gpio-cermd/outputs
write_configuration cermd.toml "offset=0 us"
circuit r_mohm 2320000,12700000,10000000,0
# Charging (GPIO13, and 19 with it) and discharging through each resistor (GPIO20, 21, 16).
phases="8192 532480 1048576 2097152 65536"
# all_met: whether the daemon has been killed in each of them.
all_met() {
    for mask in $phases; do
        grep "^$mask " rounds >/dev/null || return 1
    done
}
# The first cycles, each with a discharge that is held for 40 ms to see leaks, take some 75 ms: 40 instants that are spread over 88 ms, in
# an order that mixes them. The shortest phase takes a millisecond, and when a cycle begins is not known: further instants, between
# these, until all phases have been met.
round=0
while [ $round -lt 40 ] || { [ $round -lt 160 ] && ! all_met; }; do
    start_cermd cermd.toml
    raw $CERMD_SOCKET >stream &
    client=$!
    until_true 100 test -s stream
    usleep $((50000 + round * 17 % 40 * 2200 + round / 40 * 550))
    kill -KILL $cermd
    wait $cermd 2>/dev/null || true
    wait $client || true
    left=$(cat $outputs)
    cermd --config cermd.toml --release-lines 2>>cleaner.log || fail "the cleaner failed"
    after=$(cat $outputs)
    echo "$left $after $(wc -l <stream)" >>rounds
    [ "$after" = 0 ] || fail "round $round: lines $after drive after the cleaner"
    [ "$(tail -c 1 stream | od -An -tx1 | tr -d ' ')" = 0a ] || fail "round $round: half a line"
    grep -v '^{"class":"[A-Z]*",.*}$' stream && fail "round $round: not a line"
    round=$((round + 1))
done
mawk '{ n += $3 } END { print n, "lines at clients"; exit n <= NR }' rounds || fail "no client has got a reading"
echo "masks of lines that drove after the kill, and how often:"
cut -d' ' -f1 rounds | sort | uniq -c
all_met || fail "not all phases were met: $phases"
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"
