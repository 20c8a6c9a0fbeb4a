# The plain C program with libgpiod: what a reading may cost.
tpcm 100
