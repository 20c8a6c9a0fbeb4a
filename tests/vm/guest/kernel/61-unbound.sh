# The chip disappears under load and comes back: faults that say so, then readings, all by itself.
. /test/lib.sh
driver=/sys/bus/platform/drivers/gpio-cermd
write_configuration cermd.toml
start_cermd cermd.toml
raw $CERMD_SOCKET >stream &
client=$!
for round in 1 2 3; do
    sleep 1.337
    count=$(stat ok)
    faults=$(stat pins)
    echo gpio-cermd >$driver/unbind
    sleep 2
    [ "$(stat pins)" -gt "$faults" ] || fail "round $round: no fault: $(cermctl stats --json)"
    echo gpio-cermd >$driver/bind
    sleep 2.5
    [ "$(stat ok)" -gt $((count + 10)) ] || fail "round $round: no readings after the chip has come back"
done
stop_cermd
wait $client
cat cermd.log
[ "$(grep -c '"status":"fault","fault":"pins"' stream)" -ge 3 ] || fail "clients were not told"
[ "$(grep -c 'is gone' cermd.log)" = 3 ] || fail "the log does not say each time that the chip is gone"
[ "$(grep -c 'the GPIO lines work again' cermd.log)" = 3 ] || fail "the log does not say each time that it is back"
# One in some hundred readings is a fault by itself.
[ "$(tail -n 20 stream | grep -c '"status":"ok"')" -ge 18 ] || fail "readings do not go on: $(tail -n 20 stream)"
[ "$(cat /sys/kernel/debug/gpio-cermd/outputs)" = 0 ] || fail "lines drive after the end"
