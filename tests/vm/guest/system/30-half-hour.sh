# Half an hour of service: memory flat, the offset does not drift, the watchdog is fed, no reading is a fault.
. /test/lib.sh
export CERMD_SOCKET=/run/cermd/cermd.sock
circuit late_ns 6000
circuit jitter_ns 1500
mkdir -p /etc/cermd
write_configuration /etc/cermd/cermd.toml rate=2
systemd-sysusers
udevadm control --reload
udevadm trigger --action=add
udevadm settle
systemctl start cermd
pid=$(systemctl show --value --property=MainPID cermd)
rss() { sed -n 's/^VmRSS:[^0-9]*\([0-9]*\) kB/\1/p' "/proc/$pid/status"; }
until_true 2000 offset_known || fail "no offset is known"
for minute in $(seq 0 30); do
    echo "$minute $(rss) $(stat offset_ns) $(stat offset_u_ns) $(stat readings) $(stat ok)"
    sleep 60
done | tee minutes
[ "$(systemctl show --value --property=NRestarts cermd)" = 0 ] || fail "it was restarted"
[ "$(systemctl show --value --property=MainPID cermd)" = "$pid" ] || fail "it was restarted"
systemctl stop cermd
# Later offsets share rounds with the first one, so the sum of both variances is more than that of the difference.
mawk 'NR == 2 { rss = $2 }
    NR == 1 { d = $3; u = $4 }
    NR > 2 && $2 > rss { print "memory grows: " rss " kB, then " $2; bad = 1 }
    ($3 - d) ^ 2 > 4 * (u * u + $4 * $4) { print "minute " $1 ": the offset drifts from " d " +- " u " to " $3 " +- " $4; bad = 1 }
    END {
        print $5, "readings,", $5 - $6, "of them no number"
        # Both nodes disagree by five sigma in one of two million, by four and a half in one of 150 000.
        exit bad || $6 < 0.999 * $5 || $5 < 3500
    }' minutes || fail "not as at the beginning"
