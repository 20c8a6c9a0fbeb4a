# The bridges as services beside the daemon: they serve, go on when it is restarted, wait for what is not there, and end.
. /test/package/service.sh
install /test/cermd_*_arm64.deb
write_configuration $config method=tracked
echo "ARGUMENTS=--broker 127.0.0.1" >/etc/cermd/mqtt
bridges="prometheus iio web mqtt"
# ask PORT REQUEST: what is answered within a second.
ask() (
    exec 4<>"/dev/tcp/127.0.0.1/$1"
    printf "$2" >&4
    timeout 1 cat <&4 || true
)
get() { ask "$1" "GET $2 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n" | tr -d '\r'; }
# The newest number, as each of them has it.
prometheus() { get 9839 /metrics | sed -n 's/^cermd_resistance_ohms{channel="x"} //p'; }
iio() { ask 30431 'READ iio:device0 INPUT resistance0 input\r\nEXIT\r\n' | tr -d '\0' | sed -n 's/^\([0-9]*\.[0-9]*\)$/\1/p'; }
web() { get 8390 /events | sed -n 's/.*"r_ohm":\([0-9.]*\).*/\1/p' | tail -n 1; }
journal() { journalctl --unit="cermd-$1" --output=cat --no-pager; }
has_changed() {
    is=$($1)
    [ -n "$is" ] && [ "$is" != "$was" ]
}
# all_serve WHEN: each of the three has a number near 1 kohm, and later another one; the fourth waits.
all_serve() {
    for bridge in prometheus iio web; do
        was=
        until_true 40 has_changed $bridge || { journal $bridge; fail "$1: $bridge has no number"; }
        was=$is
        until_true 40 has_changed $bridge || fail "$1: $bridge stays at $was"
        echo "$1: $bridge: $was, then $is"
        between "$is" 900 1100
    done
    for bridge in $bridges; do
        [ "$(property ActiveState cermd-$bridge) $(property NRestarts cermd-$bridge)" = "active 0" ] ||
            fail "$1: cermd-$bridge is $(property ActiveState cermd-$bridge), after $(property NRestarts cermd-$bridge) restarts"
    done
}
pids() { for bridge in $bridges; do property MainPID cermd-$bridge; done; }

echo "== before the daemon"
for bridge in $bridges; do systemctl start cermd-$bridge; done
for bridge in $bridges; do
    until_true 40 sh -c "journalctl --unit=cermd-$bridge --output=cat | grep 'trying again every'" || fail "$bridge does not say that it waits"
    [ "$(ps -o uid= -p "$(property MainPID cermd-$bridge)" | tr -d ' ')" != 0 ] || fail "$bridge runs as root"
done
get 9839 /metrics | grep '^cermd_up 0$' || fail "the metrics do not say that there is no daemon"
pids >before

echo "== beside it"
systemctl start cermd
until_true 200 reading || fail "no reading: $(cermctl get --json)"
all_serve started
get 8390 / | grep '<title>' || fail "there is no page"
journal mqtt | grep '^broker 127.0.0.1:1883: .*trying again every' || { journal mqtt; fail "nobody says that the broker is waited for"; }
[ "$(journal mqtt | grep -c '^broker ')" = 1 ] || { journal mqtt; fail "that fills the log"; }

for how in "systemctl restart cermd" "systemctl kill --signal=KILL --kill-whom=main cermd"; do
    echo "== $how"
    pid=$(property MainPID)
    $how
    until_true 100 sh -c "[ \"\$(systemctl show --value --property=MainPID cermd)\" != $pid ]" || fail "it is the same process"
    until_true 200 reading || fail "no reading: $(cermctl get --json)"
    all_serve "$how"
    pids | cmp - before || fail "a bridge was started again"
done

echo "== without it"
systemctl stop cermd
until_true 40 sh -c "exec 4<>/dev/tcp/127.0.0.1/9839; printf 'GET /metrics HTTP/1.0\r\nHost: localhost\r\n\r\n' >&4; grep '^cermd_up 0' <&4" ||
    fail "the metrics do not say that the daemon has gone"
pids | cmp - before || fail "a bridge has ended with the daemon"
for bridge in $bridges; do
    now
    systemctl stop cermd-$bridge
    echo "cermd-$bridge stopped in $(ms) ms"
    between "$(ms)" 0 3000
    is_over cermd-$bridge
done
get 9839 /metrics 2>/dev/null | grep . && fail "somebody still serves metrics"
rm /etc/cermd/mqtt
