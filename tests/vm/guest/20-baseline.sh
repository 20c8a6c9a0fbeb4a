# The plain C program with libgpiod: what a reading may cost.
tpcm 100
gpioinfo --chip /dev/gpiochip1 GPIO5 GPIO16
