# systemd is up, nothing failed, udev knows the chip, and without a rule it is root's alone.
. /test/lib.sh
systemctl --version | head -n 1
systemctl --failed --no-legend --plain | tee failed
[ ! -s failed ] || fail "units failed"
udevadm settle
udevadm info --query=property "/dev/$(chip)" | grep -E '^(DEVNAME|SUBSYSTEM)='
gpioinfo --chip "$(chip)" GPIO5
[ "$(as_user id -u)" = 1000 ] || fail "as_user does not work"
as_user gpioinfo --chip "$(chip)" GPIO5 && fail "an unprivileged user can open the chip"
probe v2
