# For: one run of a machine and what it leaves. Must not know: what is in its root file system.
#
# Deterministic time: one processor, one emulating thread, and a clock that counts executed instructions (shift=1: 2 ns
# each) instead of the host's; while the guest idles it jumps to the next timer. With still-clock.c nothing of the host
# shows in the guest.

# boot NAME KERNEL OUT SECONDS QEMU_OPTION...: console to OUT.console, the files of /results to the folder OUT.
boot() {
    local name=$1 kernel=$2 out=$3 limit=$4 tree=$cache/tree/qemu
    local lib=$tree/usr/lib/x86_64-linux-gnu
    shift 4
    rm -rf "$out" "$out.console"
    mkdir -p "$out"
    LD_PRELOAD=$cache/build/still-clock.so LD_LIBRARY_PATH=$lib:$tree/lib/x86_64-linux-gnu QEMU_MODULE_DIR=$lib/qemu \
        timeout --foreground -k 5 "$limit" "$tree/usr/bin/qemu-system-aarch64" -L "$tree/usr/share/qemu" \
        -M virt,dtb-randomness=off -cpu cortex-a72 -m 512 -accel tcg,thread=single \
        -icount shift=1,sleep=off,align=off -rtc base=2026-01-01T00:00:00,clock=vm \
        -nographic -no-reboot -nic none -kernel "$kernel" "$@" </dev/null >"$out.console" 2>&1 ||
        { echo "$name: the machine did not end within $limit s or failed, see $out.console" >&2; return 1; }
    # The console holds the archive between two markers; its own checksums tell if a kernel message got into it.
    sed -n '/^-----BEGIN RESULTS/,/^-----END RESULTS/p' "$out.console" | tr -d '\r' | grep -v '^-----' |
        base64 -d | tar -xz -C "$out" ||
        { echo "$name: no results, see $out.console" >&2; return 1; }
}

command_line="console=ttyAMA0 quiet panic=-1 systemd.show_status=false mitigations=off nokaslr audit=0 apparmor=0"
command_line+=" lsm= random.trust_cpu=on rcupdate.rcu_expedited=1"

# kernel_image SUITE
kernel_image() {
    local tree=$cache/tree/kernel-$1 v file
    v=$(cat "$tree.version")
    for file in "$tree/usr/lib/modules/$v/vmlinuz" "$tree/boot/vmlinuz-$v"; do
        [ ! -e "$file" ] || echo "$file"
    done
}
