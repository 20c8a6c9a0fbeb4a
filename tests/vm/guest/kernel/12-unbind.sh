# The chip can disappear under a running program and come back.
. /test/lib.sh
driver=/sys/bus/platform/drivers/gpio-cermd
tpcm 1000 &
sleep 1
echo gpio-cermd >$driver/unbind
wait $! && fail "the program did not notice"
[ -z "$(chip)" ] || fail "the chip is still there"
echo gpio-cermd >$driver/bind
probe v2
