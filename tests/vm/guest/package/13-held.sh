# A line that another program holds, or a socket that it serves: the service waits, says for whom, measures when that is over, and ends at
# once while it waits.
. /test/package/service.sh
install /test/cermd_*_arm64.deb
write_configuration $config method=tracked
holds() { cermctl lines | grep 'held by "another"'; }
hold() {
    case $1 in
    GPIO5) gpiomon --consumer another --chip "$(chip)" --edges falling GPIO5 >holding 2>&1 & ;;
    *) gpioset --consumer another --chip "$(chip)" "$1=1" >holding 2>&1 & ;;
    esac
    holder=$!
    until_true 40 holds || fail "nobody holds $1: $(cat holding)"
}
let_go() {
    kill $holder
    wait $holder || true
}
# waits LINE: it is alive, says who holds the line, and has not been started again.
waits() {
    systemctl status --full --no-pager cermd >status
    cat status
    grep "Status: \"waiting: .*held by another consumer: $1 (\"another\")" status >/dev/null || fail "the status does not say who holds $1"
    [ "$(property ActiveState) $(property NRestarts)" = "active 0" ] || fail "it is $(property ActiveState), after $(property NRestarts) restarts"
}
told() { journalctl --unit=cermd --output=cat --no-pager --since="$since" | grep -c 'held by another consumer' || true; }

# One that senses, one that drives.
for line in GPIO5 GPIO20; do
    echo "== $line is held"
    hold $line
    since=$(date '+%F %T')
    now
    systemctl start cermd
    echo "started after $(ms) ms"
    waits $line
    until_true 100 sh -c "cermctl get --json | grep '\"fault\":\"pins\"'" || fail "clients are not told: $(cermctl get --json)"
    sleep 5
    waits $line
    [ "$(told)" = 1 ] || { journalctl --unit=cermd --no-pager; fail "told $(told) times"; }
    now
    let_go
    until_true 100 reading || fail "it does not start by itself: $(cermctl get --json)"
    echo "measures $(ms) ms after the line was let go"
    between "$(ms)" 0 2000
    [ "$(property NRestarts)" = 0 ] || fail "it was restarted"
    until_true 200 sh -c 'systemctl show --property=StatusText cermd | grep " readings, "' || fail "the status still says $(property StatusText)"
    systemctl stop cermd
    is_over cermd
    lines_are_safe stopped
    # Let the next part of the journal begin in another second.
    sleep 1

    echo "== it ends while $line is held"
    hold $line
    systemctl start cermd
    waits $line
    now
    systemctl stop cermd
    echo "stopped in $(ms) ms"
    between "$(ms)" 0 3000
    is_over cermd
    holds || fail "the line was taken from its holder"
    let_go
    sleep 1
done

echo "== by hand it says so and ends"
hold GPIO5
status=0
mkdir -p /run/cermd
timeout 10 cermd --config $config >said 2>&1 || status=$?
cat said
[ $status = 1 ] || fail "exit status $status"
grep 'held by another consumer: GPIO5 ("another")' said || fail "it does not say who holds which line"
let_go
echo "== its socket is served by another"
mkdir -p /run/cermd
write_configuration other.toml backend=mock method=tracked r_c1="470 ohm"
printf "\n[mock]\nscene = \"pi4\"\n" >>other.toml
cermd --config other.toml 2>other.log &
other=$!
until_true 100 reading || fail "the other one does not measure: $(cat other.log)"
since=$(date '+%F %T')
systemctl start cermd
sleep 3
systemctl status --full --no-pager cermd >status
cat status
grep "Status: \"no socket: .* is already served by pid $other[: ]" status >/dev/null || fail "the status does not say who serves"
[ "$(property ActiveState) $(property NRestarts)" = "active 0" ] || fail "it is $(property ActiveState), after $(property NRestarts) restarts"
said=$(journalctl --unit=cermd --output=cat --no-pager --since="$since" | grep -c 'is already served' || true)
[ "$said" = 1 ] || fail "told $said times"
kill $other
wait $other || true
now
until_true 100 reading || fail "it does not take over: $(systemctl status --full --no-pager cermd)"
echo "measures $(ms) ms after the other one's end"
between "$(ms)" 0 2000
[ "$(property NRestarts)" = 0 ] || fail "it was restarted"
systemctl stop cermd
is_over cermd
lines_are_safe stopped
systemctl --failed --no-legend --plain | tee failed
[ ! -s failed ] || fail "units failed"
