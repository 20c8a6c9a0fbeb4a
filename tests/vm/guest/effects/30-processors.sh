# Two processors: the daemon stays on one of them, the timers of the circuit and the rest of the system may be on the other.
. /test/lib.sh
. /test/accuracy.sh
[ "$(grep -c '^processor' /proc/cpuinfo)" = 2 ] || exit 77
circuit late_ns 6000
circuit jitter_ns 1500
for method in cerm tracked; do
    begin method=$method
    column $method 60 "100 1000 5000 16200"
    finish
    rm tape
    judged $method $([ $method = cerm ] && echo own || echo shared)
done
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"
