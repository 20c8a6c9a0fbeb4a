# Other programs beside the daemon: they see who holds the lines, and disturb nothing.
. /test/lib.sh
# Whether all readings so far were numbers, and there are new ones. Programs that start keep the processor busy, and now and
# then a stamp is late for that; then it is refused and told, where one stretch tells nothing else as `unsettled` or as a number that moves. One crossing in
# 400 is late of itself (docs/latency.md) and a reading has six of them: one such reading in fifty is no disturbance.
undisturbed() {
    before=$(stat readings)
    sleep 2
    cermctl stats --json >stats
    count() { grep -o "\"$1\":[0-9]*" stats | head -n 1 | cut -d : -f 2; }
    readings=$(count readings)
    ok=$(count ok)
    late=$(($(count latency-outlier) + $(count unsettled)))
    [ "$readings" -gt "$before" ] && [ $((ok + late)) = "$readings" ] && [ $(((late + $(count moving)) * 50)) -le "$readings" ] || fail "disturbed: $(cat stats)"
}

# The noise of a board: with the kernel's own alone, a gate of five sigma is narrower than what a busy processor does.
circuit late_ns 6000
circuit jitter_ns 1500
write_configuration cermd.toml
start_cermd cermd.toml
until_true 1000 offset_known

echo "gpioinfo names the holder"
gpioinfo --chip "$(chip)" | tee lines
for line in 5 6 13 19 20 21 16; do
    grep "GPIO$line\"*.*consumer=\"cermd\"" lines >/dev/null || fail "GPIO$line is not held by cermd"
done
[ "$(grep -c 'consumer=' lines)" = 7 ] || fail "other lines are held, too"

echo "gpioset on held lines"
for line in 5 6 13 19 20 21 16; do
    gpioset --chip "$(chip)" --toggle 1ms,0 "GPIO$line=1" 2>refusal && fail "gpioset took GPIO$line"
    grep -i busy refusal
done
undisturbed

echo "a second daemon on the same lines, with a socket of its own"
write_configuration second.toml socket=/run/cermd/second.sock
cermd --config second.toml 2>second.log && fail "a second daemon took the lines"
cat second.log
grep 'GPIO16 ("cermd")' second.log || fail "it does not say who holds which line"
echo "a second daemon on the same socket"
cermd --config cermd.toml 2>second.log && fail "a second daemon took the socket"
cat second.log
grep "already served by pid $cermd (cermd)" second.log || fail "it does not say who serves"

echo "an unprivileged user"
chmod 777 /tmp
write_configuration /tmp/user.toml socket=/tmp/user.sock
as_user cermd --config /tmp/user.toml 2>user.log && fail "a user without rights took the chip"
cat user.log
grep 'open to its owner alone' user.log || fail "the cause is not said"
chgrp gpio "/dev/$(chip)"
chmod 660 "/dev/$(chip)"
as_user cermd --config /tmp/user.toml 2>user.log && fail "a user without the group took the chip"
cat user.log
grep 'group gpio' user.log || fail "the group is not named"

undisturbed
stop_cermd
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"
[ "$(cat /sys/kernel/debug/gpio-cermd/outputs)" = 0 ] || fail "lines drive after the end"
