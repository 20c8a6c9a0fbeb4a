# A setup that nobody answers, and its undo: the configuration, the service and the lines are as they were before.
. /test/package/service.sh
install /test/cermd_*_arm64.deb
setup() { cermctl setup --yes --chip cermd-rc --wiring two --c-a "2.2 uF" --c-b "680 nF" --r-c1 "2.32 kohm" --r-c2 "12.7 kohm" </dev/null; }
undo() {
    cermctl setup --undo
    cmp $config before || fail "the configuration is another one than before"
    [ -z "$(ls /etc/cermd/*.before-setup* 2>/dev/null)" ] || fail "left behind: $(ls /etc/cermd)"
}

for round in first second; do
    echo "== of a service that was not enabled, the $round time"
    cp $config before
    setup
    cmp -s $config before && fail "nothing is configured"
    until_true 200 reading || fail "no reading: $(cermctl get --json)"
    [ "$(systemctl is-enabled cermd) $(systemctl is-active cermd)" = "enabled active" ] || fail "it is not enabled"
    undo
    is_over cermd
    [ "$(systemctl is-enabled cermd)" = disabled ] || fail "it is still enabled"
    lines_are_safe "taken back"
    gpioinfo --chip "$(chip)" | grep consumer= && fail "lines are still held"
done

echo "== of a service that ran"
write_configuration $config
sed -i 's/id = "x"/id = "mine"/' $config
systemctl enable --now cermd
until_true 200 reading || fail "no reading: $(cermctl get --json)"
cp $config before
setup
cermctl get mine && fail "it still runs by the configuration of before"
undo
[ "$(systemctl is-enabled cermd) $(systemctl is-active cermd)" = "enabled active" ] || fail "it does not run as before"
until_true 200 sh -c 'cermctl get mine --json | grep "\"status\":\"ok\""' || fail "no reading as before: $(cermctl get --json)"
echo "== what no setup has written is not taken back"
cermctl setup --undo && fail "it has taken something back"
cmp $config before || fail "the configuration is lost"
systemctl disable --now cermd
is_over cermd
