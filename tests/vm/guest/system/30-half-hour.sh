# Half an hour of service: memory flat, the offset does not drift, the watchdog is fed, of a thousand readings three
# are faults at most: one in 3668 was, in each of three runs, so four are by chance now and then.
. /test/lib.sh
export CERMD_SOCKET=/run/cermd/cermd.sock
circuit late_ns 6000
circuit jitter_ns 1500
mkdir -p /etc/cermd
write_configuration /etc/cermd/cermd.toml rate=2 idle=true
systemd-sysusers
udevadm control --reload
udevadm trigger --action=add
udevadm settle
systemctl start cermd
pid=$(systemctl show --value --property=MainPID cermd)
rss() { sed -n 's/^VmRSS:[^0-9]*\([0-9]*\) kB/\1/p' "/proc/$pid/status"; }
until_true 2000 offset_known || fail "no offset is known"
# The first of that name: each channel has counters, too.
field() { grep -o "\"$1\":[^,}]*" stats | head -n 1 | cut -d : -f 2; }
for minute in $(seq 0 30); do
    cermctl stats --json >stats
    echo "$minute $(rss) $(field offset_ns) $(field offset_u_ns) $(field readings) $(field ok)"
    sleep 60
done | tee minutes
[ "$(systemctl show --value --property=NRestarts cermd)" = 0 ] || fail "it was restarted"
[ "$(systemctl show --value --property=MainPID cermd)" = "$pid" ] || fail "it was restarted"
systemctl stop cermd
# The allocator takes its last pages in the first minutes, while the first clients come and go.
# Twenty offsets, of which four or five are independent, are compared with the first one: four standard uncertainties.
mawk 'NR == 11 { rss = $2 }
    NR == 1 { d = $3; u = $4 }
    NR > 11 && $2 != rss { print "memory changes: " rss " kB, then " $2; bad = 1 }
    ($3 - d) ^ 2 > 16 * (u * u + $4 * $4) { print "minute " $1 ": the offset drifts from " d " +- " u " to " $3 " +- " $4; bad = 1 }
    END {
        print $5, "readings,", $5 - $6, "of them no number"
        exit bad || $6 < 0.997 * $5 || $5 < 3500
    }' minutes || fail "not as at the beginning"
