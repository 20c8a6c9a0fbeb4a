# Helpers for tests of the package: `. /test/package/service.sh`.
. /test/lib.sh
export CERMD_SOCKET=/run/cermd/cermd.sock
config=/etc/cermd/cermd.toml
property() { systemctl show --value --property="$1" "${2:-cermd}"; }
reading() { cermctl get --json | grep '"status":"ok"'; }
install() { DEBIAN_FRONTEND=noninteractive apt-get install -y -o Dpkg::Options::=--force-confold "$1" </dev/null; }
ms() { echo $((($(date +%s%N) - from) / 1000000)); }
now() { from=$(date +%s%N); }
lines_are_safe() { [ "$(cat /sys/kernel/debug/gpio-cermd/outputs)" = 0 ] || fail "$1: lines drive"; }
# is_over UNIT: it has ended, and well.
is_over() {
    [ "$(property ActiveState "$1") $(property Result "$1")" = "inactive success" ] ||
        fail "$1 is $(property ActiveState "$1"), $(property Result "$1")"
}
