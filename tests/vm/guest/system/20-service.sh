# The unit, the rule and the service under a real systemd.
. /test/lib.sh
outputs=/sys/kernel/debug/gpio-cermd/outputs
export CERMD_SOCKET=/run/cermd/cermd.sock
property() { systemctl show --value --property="$1" cermd; }
serves() { cermctl get; }
# until_served WHAT MS: it serves again, at most so long after $from (ns).
until_served() {
    until_true 100 serves || { journal; fail "$1: it does not serve"; }
    ms=$((($(date +%s%N) - from) / 1000000))
    echo "$1: serves after $ms ms"
    # The rest is tested all the same.
    [ $ms -le "$2" ] || late="$late $1 ($ms ms)"
}
# Whether it has ended, and its next start is still to come.
pauses() { [ "$(property SubState)" = auto-restart ]; }
# until_restarted WHAT COUNT
until_restarted() {
    restarts=$2
    until_true 100 was_restarted || fail "$1: restarts: $(property NRestarts), not $2"
}
was_restarted() { [ "$(property NRestarts)" = "$restarts" ]; }
late=
now() { from=$(date +%s%N); }
journal() { journalctl --unit=cermd --output=cat --no-pager | tail -n 30; }
lines_are_safe() { [ "$(cat $outputs)" = 0 ] || fail "$1: lines $(cat $outputs) drive"; }

systemd-analyze verify --man=no /usr/lib/systemd/system/cermd.service
# Exposure in tenths.
systemd-analyze security --offline=true --threshold=15 --no-pager /usr/lib/systemd/system/cermd.service | tail -n 1
systemd-sysusers
grep '^gpio:' /etc/group
grep '^cermd:' /etc/group
udevadm control --reload
udevadm trigger --action=add
udevadm settle
stat_of() { /usr/bin/stat -c '%U %G %a' "$1"; }
[ "$(stat_of "/dev/$(chip)")" = "root gpio 660" ] || fail "the rule: $(stat_of "/dev/$(chip)")"
[ "$(stat_of /dev/cpu_dma_latency)" = "cermd root 600" ] || fail "the rule: $(stat_of /dev/cpu_dma_latency)"
systemctl is-active "dev-$(chip).device"

mkdir -p /etc/cermd
write_configuration /etc/cermd/cermd.toml
systemctl daemon-reload
now
systemctl start cermd || { journal; fail "it does not start"; }
[ "$(property ActiveState)" = active ] || fail "not active: $(property ActiveState)"
until_served start 1000
pid=$(property MainPID)
echo "user $(ps -o user= -p "$pid"), status $(property StatusText)"
[ "$(ps -o uid= -p "$pid" | tr -d ' ')" != 0 ] || fail "it runs as root"
cermctl stats --json | grep -o '"realtime".*}'
for right in priority lock-memory cpu dma-latency; do
    [ "$(stat $right)" = granted ] || { cermctl stats --json; fail "$right is not granted"; }
done
gpioinfo --chip "$(chip)" | grep 'consumer="cermd"' >/dev/null || fail "no line is held"

echo "clients"
setpriv --reuid=1000 --regid=1000 --groups="$(sed -n 's/^cermd:[^:]*:\([0-9]*\):.*/\1/p' /etc/group)" cermctl get || fail "the group may not talk to it"
as_user cermctl get 2>refused && fail "everybody may talk to it"
cat refused
grep 'usermod -aG cermd' refused || fail "the user is not told the group"

echo "reload"
sed -i 's/id = "x"/id = "y"/' /etc/cermd/cermd.toml
systemctl reload cermd
until_true 100 sh -c 'cermctl get y' || fail "the new configuration is not in force"
echo nonsense >>/etc/cermd/cermd.toml
systemctl reload cermd
cermctl get y || fail "the old configuration is not in force"
journal | grep 'the old configuration stays in force'
[ "$(property MainPID)" = "$pid" ] || fail "it was restarted"
write_configuration /etc/cermd/cermd.toml

for round in 1 2 3; do
    sleep "0.${round}7"
    now
    systemctl kill --signal=KILL --kill-whom=main cermd
    until_restarted "killed" $round
    # RestartSec=, and what the cleaner, the start and the first cycle take.
    until_served "killed" 1000
done

# Its pause is too short to look into from here.
drop_in=/run/systemd/system/cermd.service.d/pause.conf
mkdir -p ${drop_in%/*}
printf '[Service]\nRestartSec=3s\n' >$drop_in
systemctl daemon-reload
for round in 4 5 6; do
    sleep "0.$((round - 3))7"
    now
    systemctl kill --signal=KILL --kill-whom=main cermd
    until_true 100 pauses || fail "not ended"
    lines_are_safe "killed"
    until_restarted "killed, with a pause" $round
    until_served "killed, with a pause" 5000
done

# barked WHAT RESTARTS: the watchdog has ended the service, nothing drove before the next start, and it serves again.
barked() {
    until_true 400 pauses || fail "$1: the watchdog does not bark"
    lines_are_safe "$1"
    until_restarted "$1" "$2"
    until_served "$1" 20000
    journal | grep -i watchdog
}
echo "a process that is stuck"
now
systemctl kill --signal=STOP --kill-whom=main cermd
barked "stuck" 7
echo "a measuring thread that hangs, alone"
now
hang "$(property MainPID)" cermd-measure &
barked "hung" 8
wait $! || fail "the thread was not ended"

echo "killed, and its configuration is another one by then"
sed -i 's/cermd-rc/another-chip/' /etc/cermd/cermd.toml
until_true 100 sh -c "[ \"\$(cat $outputs)\" != 0 ]" || fail "no line drives"
now
systemctl kill --signal=KILL --kill-whom=main cermd
until_true 100 pauses || fail "not ended"
lines_are_safe "killed beside another configuration"
write_configuration /etc/cermd/cermd.toml
until_served "killed beside another configuration" 6000
journal | grep 'every line is an input'

systemctl stop cermd
lines_are_safe "stopped"
[ "$(property Result)" = success ] || fail "it ended with $(property Result)"
[ ! -e /run/cermd/cermd.sock ] || fail "the socket is still there"
systemctl --failed --no-legend --plain
journal
[ -z "$late" ] || fail "too late:$late"
