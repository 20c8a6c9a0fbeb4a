# The plain C program with libgpiod: what a reading may cost.
. /test/lib.sh
tpcm 100
cat "$discharges" >discharges
cat /proc/self/schedstat
