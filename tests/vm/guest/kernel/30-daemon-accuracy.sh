# What the unmodified daemon reads over its socket, against what is true.
. /test/lib.sh
. /test/accuracy.sh
for jitter in 0 500 1500; do
circuit jitter_ns $jitter
circuit late_ns $((jitter*4))
for setting in "method=cerm" ; do
echo "== $setting jitter $jitter"
begin $setting
cat lateness
grep -o '"offset.*' stats.json
for r in 100 1000; do 
circuit r_mohm "2320000,12700000,${r}000,0"
cermctl record --count 5 >/dev/null
before=$(cat $discharges | tail -n 1 | cut -d' ' -f1)
cermctl record --raw --count 500 >raw
first=$(sed -n 's/.*DISCHARGE","seq":\([0-9]*\).*/\1/p' raw | head -n 1)
tail -n 1 $discharges; tail -n 1 raw; head -2 raw
mawk -v before=0 -f /test/lateness.awk $discharges raw
readings 100 $r; done
stop_cermd
done
cp $discharges d.$jitter; cd /; sleep 1; rmmod gpio-cermd; cd -;insmod /test/gpio-cermd.ko
done
cat /proc/uptime
