# Somebody looks at all lines (debugfs) while the daemon measures: no reading is lost to it.
. /test/lib.sh
write_configuration cermd.toml
start_cermd cermd.toml
until_true 100 offset_known || fail "the offset is never found"
for round in 1 2 3 4 5; do
    sleep 0.337
    count=$(stat ok)
    grep -A 30 cermd-rc /sys/kernel/debug/gpio >looked-at || fail "there is nothing to look at"
    sleep 0.5
    [ "$(stat ok)" -gt $((count + 2)) ] || fail "round $round: no readings after a look: $(cermctl stats --json)"
done
cat looked-at
[ "$(stat pins)" = 0 ] || fail "readings were lost: $(cermctl stats --json)"
# Newer kernels leave the chargers as they are: 7.3 renews nothing, and loses nothing either.
case $(uname -r) in
6.12*) [ "$(stat lines_renewed)" -gt 0 ] || fail "nothing was renewed: $(cermctl stats --json)" ;;
esac
stop_cermd
cat cermd.log
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"
