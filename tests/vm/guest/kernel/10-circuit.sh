# The circuit in the kernel keeps the law, whichever way its lines are switched.
probe v2
probe paper
status=0
probe v1 || status=$?
# A kernel without uAPI v1 says so; that is not a fault of the circuit. 6.12 is tested because it has it: without, the tests of
# chardev-v1 would be left out, and nobody would know.
case $(uname -r) in 6.*) without=0 ;; *) without=77 ;; esac
[ $status = 0 ] || [ $status = $without ]
cat /sys/kernel/debug/gpio-cermd/discharges >discharges
[ "$(cat /sys/module/gpio_cermd/parameters/conflicts)" = 0 ]
[ "$(cat /sys/kernel/debug/gpio-cermd/outputs)" = 0 ]
