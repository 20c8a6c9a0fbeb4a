# A trigger moves its line soon after its sensor has changed; the line is inactive when there are no numbers, when the measuring
# thread hangs and at the end, and drives no more after a kill and the cleaner.
. /test/lib.sh
outputs=/sys/kernel/debug/gpio-cermd/outputs
high=/sys/kernel/debug/gpio-cermd/high
tracing=/sys/kernel/debug/tracing
[ -d $tracing/events/gpio ] || {
    tracing=/sys/kernel/tracing
    mount -t tracefs none $tracing
}
[ -d $tracing/events/gpio ] || exit 77
press() { circuit r_mohm 2320000,12700000,1000000,0; }
let_go() { circuit r_mohm 2320000,12700000,10000000,0; }
releases() { grep -c '"event":"released"' stream; }
has_told() { [ "$(releases)" -gt "$before" ]; }
drives() { [ $(($(cat $outputs) & 1 << 17)) != 0 ]; }
# Not by the kernel's own list of lines: a look at it takes the chargers from chardev-v1 (62-looked-at).
is() { drives && [ $(($(cat $high) >> 17 & 1)) = "$1" ]; }
number=$(sed -n 's/.*gpio-\([0-9]*\) *(GPIO17 .*/\1/p' /sys/kernel/debug/gpio)
backends=chardev
! probe v1 >/dev/null || backends="$backends chardev-v1"

echo mono >$tracing/trace_clock
for backend in $backends; do
    write_configuration cermd.toml backend=$backend method=tracked
    sed -i '/^id = "x"/a on-below = "5 kohm"\noutput = { line = "GPIO17" }' cermd.toml
    let_go
    start_cermd cermd.toml
    raw $CERMD_SOCKET >stream &
    client=$!
    until_true 100 grep '"event":"released"' stream || fail "nothing is known: $(tail -n 3 stream)"
    # Before, each reading is one of several calibrations, 80 ms long.
    until_true 100 settled || fail "it does not settle: $(tail -n 3 stream)"
    sleep 2
    echo "gpio == $number" >$tracing/events/gpio/gpio_value/filter
    echo >$tracing/trace
    echo 1 >$tracing/events/gpio/gpio_value/enable
    round=0
    while [ $round -lt 20 ]; do
        # At any phase of a cycle.
        usleep $((200000 + round * 7919 % 20 * 1300))
        echo step >$tracing/trace_marker
        press
        until_true 100 is 1 || fail "$backend: it is never pressed: $(tail -n 3 stream)"
        sleep 0.2
        echo step >$tracing/trace_marker
        let_go
        until_true 100 is 0 || fail "$backend: it is never released: $(tail -n 3 stream)"
        round=$((round + 1))
    done
    echo 0 >$tracing/events/gpio/gpio_value/enable
    cat $tracing/trace >trace-$backend
    # From each step to the first change of the line after it: ms, readings, and those of them that are numbers. How long that is
    # depends on the machine that emulates; that it takes one number does not, two where the step fell into the first, three where the
    # next was there before the line was asked to move. With the faults that a step makes there are six at the most.
    sleep 0.2
    mawk 'FNR == 1 { file++ }
    file == 1 && /"class":"READING"/ && match($0, /"t_mono_ns":[0-9]+/) {
        at[++readings] = substr($0, RSTART + 12, RLENGTH - 12) / 1e9
        known[readings] = /"status":"ok"/
    }
    file == 2 && /tracing_mark_write|gpio_value/ && !/^#/ {
        for (i = 1; i <= NF; i++) if ($i ~ /^[0-9]+\.[0-9]+:$/) now = $i + 0
        if (/tracing_mark_write/) from = now
        else if (from) {
            all = numbers = 0
            for (i = 1; i <= readings; i++) if (at[i] > from && at[i] <= now) { all++; numbers += known[i] }
            printf "%.2f %d %d\n", 1e3 * (now - from), all, numbers
            from = 0
        }
    }' stream trace-$backend | sort -n >late-$backend
    # Later kernels have these events no more.
    [ -s late-$backend ] || echo "$backend: this kernel traces no levels"
    [ ! -s late-$backend ] || mawk -v b=$backend '{
        late[NR] = $1
        if ($2 > all) all = $2
        if ($3 > numbers) numbers = $3
    } END {
        printf "%s: from the step to the line, %d steps: median %.1f ms, at most %.1f ms, %d readings, %d of them numbers\n",
            b, NR, late[int((NR + 1) / 2)], late[NR], all, numbers
        exit !(NR == 40 && late[1] > 0 && all <= 6 && numbers <= 3) }' late-$backend || fail "$(cat late-$backend)"

    # Crossings raise no interrupt: all readings are faults.
    press
    until_true 100 is 1 || fail "$backend: it is not pressed"
    before=$(releases)
    circuit swallow 100000
    until_true 100 is 0 || fail "$backend: it stays pressed without a number"
    until_true 100 has_told || fail "$backend: nobody is told"
    grep '"event":"released"' stream | tail -n 1 | grep '"reason":"fault"' || fail "$backend: another reason is told"
    circuit swallow 0

    # The measuring thread hangs: the line is let go of without it. Where the last reading before was a fault, that is the
    # reason that is told: once more then.
    press
    for attempt in 1 2 3; do
        until_true 100 is 1 || fail "$backend: it is not pressed"
        before=$(releases)
        hang $cermd cermd-measure &
        hanging=$!
        until_true 100 is 0 || fail "$backend: nobody notices that the measuring thread hangs"
        until_true 100 has_told || fail "$backend: nobody is told"
        grep '"event":"released"' stream | tail -n 1 | grep -E '"reason":"(stale|fault)"' || fail "$backend: another reason is told"
        kill $hanging
        wait $hanging || true
        until_true 100 is 1 || fail "$backend: it does not go on"
        ! grep '"event":"released","reason":"stale"' stream || break
    done
    grep '"event":"released","reason":"stale"' stream || fail "$backend: nobody is told why"

    kill $client
    stop_cermd
    ! drives || fail "$backend: the line drives after the end"

    start_cermd cermd.toml
    until_true 100 is 1 || fail "$backend: it is not pressed"
    kill -KILL $cermd
    wait $cermd 2>/dev/null || true
    trap - EXIT
    ! drives || echo "$backend: the line drives after the kill"
    cermd --config cermd.toml --release-lines || fail "$backend: the cleaner failed"
    [ "$(cat $outputs)" = 0 ] || fail "$backend: lines $(cat $outputs) drive after the cleaner"
    wait $client 2>/dev/null || true
done
cat cermd.log
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"
