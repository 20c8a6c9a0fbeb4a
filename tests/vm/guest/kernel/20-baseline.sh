# The plain C program with libgpiod: what a reading may cost.
tpcm 100
cat /sys/kernel/debug/gpio-cermd/discharges >discharges
