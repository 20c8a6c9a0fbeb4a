# The archive of static programs for a 32-bit board, which 64-bit kernels run as well: their calls to the kernel have another layout. How
# exact readings are is for the other images to say; a call that is not understood gives nothing like it.
. /test/lib.sh
# Not with the results.
archive=/tmp/archive
mkdir $archive
tar -xzf /test/armhf/cermd-*-armhf-static.tar.gz --strip-components 1 -C $archive
PATH=$archive:$PATH
[ "$(head -c 5 "$(command -v cermd)" | od -An -tx1 | tr -d ' ')" = 7f454c4601 ] || fail "this is no 32-bit program"

echo "== where there is nothing but the archive"
socket=/run/cermd/cermd.sock
mkdir -p $archive/run/cermd
chroot $archive /cermd --version
chroot $archive /cermctl --version
chroot $archive /cermctl setup --yes --scene pi4 --config /simulated.toml
chroot $archive /cermd --config /simulated.toml 2>simulated.log &
simulated=$!
until_true 200 sh -c "chroot $archive /cermctl get --json --socket $socket | grep '\"status\":\"ok\"'" || { cat simulated.log; fail "no reading"; }
chroot $archive /cermctl get --socket $socket
kill $simulated
wait $simulated || fail "it ended with exit status $?"

for backend in chardev chardev-v1; do
    echo "== $backend"
    for ohm in 100 1000 16200; do
        circuit r_mohm "2320000,12700000,${ohm}000,0"
        write_configuration cermd.toml method=tracked backend=$backend
        start_cermd cermd.toml
        # The reading found is the one judged: the next may be a fault, when something kept the kernel.
        until_true 200 settled || fail "$ohm ohm: no reading that has settled: $(cermctl get --json)"
        cat reading
        cermctl stats --json
        stop_cermd
        [ "$(cat /sys/kernel/debug/gpio-cermd/outputs)" = 0 ] || fail "lines drive"
        field() { sed -n "s/.*\"$1\":\([0-9.]*\).*/\1/p" reading; }
        mawk -v r="$(field r_ohm)" -v u="$(field r_u_ohm)" -v true="$ohm" 'BEGIN {
            print r - true " ohm off, u " u
            exit !(u > 0 && u < 0.02 * true && (r - true) ^ 2 < (0.02 * true) ^ 2)
        }' || fail "that is not $ohm ohm"
    done
done
