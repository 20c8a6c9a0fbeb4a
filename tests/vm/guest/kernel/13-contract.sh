# What the backends of the daemon owe to their user, on the real kernel.
contract --chip cermd-rc
contract --chip cermd-rc --sense-charges
if probe v1 >/dev/null; then contract --chip cermd-rc --backend chardev-v1; fi
[ "$(cat /sys/module/gpio_cermd/parameters/conflicts)" = 0 ]
[ "$(cat /sys/kernel/debug/gpio-cermd/outputs)" = 0 ]
