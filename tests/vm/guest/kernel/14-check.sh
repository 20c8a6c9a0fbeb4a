# `cermctl check` on real lines: a circuit that is as it should be, then one defect at a time, each named with its line.
. /test/lib.sh
# check STATUS: its words, in the file `found`; nothing drives afterwards.
check() {
    status=0
    cermctl check --config cermd.toml >found 2>&1 || status=$?
    cat found
    [ $status = "$1" ] || fail "exit status $status"
    [ "$(cat /sys/kernel/debug/gpio-cermd/outputs)" = 0 ] || fail "lines drive"
}
# says WORDS: they are among what it has found.
says() { grep -F "$1" found >/dev/null || fail "it does not say: $1"; }
# counted TITLE: how many latencies there are below this title.
counted() { mawk -v title="$1" '/^How/ { on = index($0, title) } on && / us |later/ { n += /#$/ ? $(NF - 1) : $NF } END { print n }' found; }

write_configuration cermd.toml
echo "== as it should be"
check 0
says "info: gpio: the chip is there, and every line can be had"
says "info: realtime.priority: granted"
says "info: wiring: the nodes charge, hold, and fall in order"
# Of one discharge each, whose stamps differ by up to 5 us (the histogram below): 10 ohm each, with g_A = 484 nF.
reads=$(mawk '/info: channel.x.sink: the sensor is there and reads about [0-9.]+ k?ohm$/ { print $(NF - 1) * ($NF == "kohm" ? 1000 : 1) }' found)
[ -n "$reads" ] || fail "it does not say what the sensor reads"
between "$reads" 985 1015
[ "$(counted "How late a sleep of 1 ms ends")" = 300 ] || fail "wake-ups: $(counted "How late a sleep of 1 ms ends")"
[ "$(counted "How late equal crossings")" = 50 ] || fail "crossings: $(counted "How late equal crossings")"

echo "== the wire of sense line A is cut"
circuit cut 0x20
check 1
says "error: gpio.sense-a: node A stays high while node B falls"
echo "== the wire of Rc1 is cut"
circuit cut 0x100000
check 1
says "error: gpio.sink-c1: nothing falls"
echo "== the wire of a charger is cut"
circuit cut 0x2000
check 1
says "error: gpio.charge-a: node A is low after the charge"
echo "== the wire of the sensor is cut"
circuit cut 0x10000
check 0
says "warning: channel.x.sink: no discharge through the sensor"
circuit cut 0
echo "== Rc1 and Rc2 swapped"
circuit r_mohm 12700000,2320000,1000000,0
check 1
says "error: circuit.r-c1: Rc1 and Rc2 look swapped"
circuit r_mohm 2320000,12700000,1000000,0

echo "== a line is held by another program"
gpiomon --chip "$(chip)" --edges falling GPIO5 >monitored 2>&1 &
holder=$!
until_true 40 sh -c 'cermctl lines | grep "held by .gpiomon"' || fail "gpiomon does not hold GPIO5: $(cat monitored)"
check 1
says 'held by another consumer: GPIO5 ("gpiomon")'
kill $holder
wait $holder || true

echo "== a user without the group"
chgrp gpio "/dev/$(chip)"
chmod 660 "/dev/$(chip)"
status=0
as_user cermctl check --config "$PWD/cermd.toml" >found 2>&1 || status=$?
cat found
[ $status = 1 ] || fail "exit status $status"
says "add yourself to group gpio"

echo "== while the service runs"
start_cermd cermd.toml
status=0
cermctl check --config cermd.toml >found 2>&1 || status=$?
cat found
[ $status = 0 ] || fail "exit status $status"
says "cermd holds the lines and measures"
cermctl lines >found
cat found
# held NAME STATE: the list has this line, its direction and settings, and cermd as its holder.
held() { grep "$1  *$2  *held by \"cermd\"$" found >/dev/null || fail "not in the list: $1 $2"; }
says "[cermd-rc] /dev/$(chip), 28 lines"
for line in GPIO5 GPIO6; do held $line "input bias-disabled falling-edges"; done
for line in GPIO13 GPIO19; do held $line "output open-source bias-disabled"; done
for line in GPIO16 GPIO20 GPIO21; do held $line "output open-drain bias-disabled"; done
[ "$(grep -c 'held by "cermd"' found)" = 7 ] || fail "other lines are held, too"
stop_cermd
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"

echo "== a second daemon on the same lines"
start_cermd cermd.toml
sed 's|^socket = .*|socket = "/run/cermd/second.sock"|' cermd.toml >second.toml
status=0
timeout 20 cermd --config second.toml >second 2>&1 || status=$?
cat second
[ $status = 1 ] || fail "exit status $status"
grep -F '("cermd")' second || fail "it does not say who holds which line"
cermctl get || fail "the first one does not serve any more"
stop_cermd
