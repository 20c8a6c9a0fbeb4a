# For: the small root file system, an initramfs: busybox, libgpiod's tools, the module, our programs, the guest tests.
# Must not know: what the tests do.

# image_small SUITE: leaves $cache/build/SUITE.initrd
image_small() {
    local root=$cache/build/root-$1 tree=$cache/tree lib=usr/lib/$cross name
    rm -rf "$root"
    mkdir -p "$root"/{proc,sys,dev,etc,tmp,run,results,usr/bin,"$lib"}
    ln -s usr/bin usr/lib "$root"
    cp -a "$tree/guest/usr/lib/ld-linux-aarch64.so.1" "$root/usr/lib"
    for name in ld-linux-aarch64.so.1 libc.so.6 libm.so.6 libgcc_s.so.1 libgpiod.so.3; do
        cp -L "$tree/guest/$lib/$name" "$root/$lib"
    done
    cp "$tree/guest/usr/bin"/{busybox,gpio*,mawk} "$root/usr/bin"
    ln -s busybox "$root/usr/bin/sh"
    printf '%s\n' 'root:x:0:0::/:/bin/sh' 'user:x:1000:1000::/tmp:/bin/sh' >"$root/etc/passwd"
    printf '%s\n' 'root:x:0:' 'gpio:x:997:' 'user:x:1000:' >"$root/etc/group"
    image_tests "$root" "$1"
    image_programs "$root"
    install -m 755 "$here/guest/init" "$root/init"
    pack_initramfs "$root" "$1"
}

# image_tests ROOT SUITE: what all root file systems have: /test.
image_tests() {
    mkdir -p "$1/test"
    cp -r "$here"/guest/. "$1/test"
    with_cross $cross-strip -g -o "$1/test/gpio-cermd.ko" "$cache/build/module-$2/gpio-cermd.ko"
}

# image_programs ROOT: the programs under test, and those of the tests.
image_programs() {
    cp "$cache/build/target/$target/release"/{cermd,cermctl} "$cache/build/target/$target/release/examples/contract" \
        "$cache"/build/{probe,raw,hang,tpcm} "$1/usr/bin"
}

# pack_initramfs ROOT NAME: the same files give the same bytes in each run: sorted, of one owner and date, with numbers of
# their own in the place of inodes and devices. How long the kernel unpacks them sets its clock, and with it every instant.
pack_initramfs() {
    find "$1" -exec touch -h -d @1767225600 {} +
    (cd "$1" && find . | LC_ALL=C sort | "$cache/tree/cpio/bin/cpio" -o -H newc -R 0:0 --reproducible --quiet) |
        gzip -1n >"$cache/build/$2.initrd"
    echo "$2: image $(sha256sum "$cache/build/$2.initrd" | cut -c 1-16)"
}
