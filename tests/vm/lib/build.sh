# For: the kernel module, the C programs and the Rust programs, all for arm64, below $cache/build. Must not know: how
# they get into a machine.

cross=aarch64-linux-gnu
target=aarch64-unknown-linux-gnu
root_of_crate=$(cd "$here/../.." && pwd)

# with_cross COMMAND...: the cross compiler's programs and libraries first.
with_cross() {
    PATH=$cache/tree/cross/usr/bin:$PATH \
        LD_LIBRARY_PATH=$cache/tree/cross/usr/lib/x86_64-linux-gnu:$cache/tree/cross/lib/x86_64-linux-gnu "$@"
}

# build_module SUITE
build_module() {
    local tree=$cache/tree/headers-$1 v out=$cache/build/module-$1 src
    v=$(cat "$cache/tree/kernel-$1.version")
    src=$tree/usr/src/linux-headers-$v
    headers_relocate "$tree" "$v"
    mkdir -p "$out"
    rm -f "$out"/*.ko
    cp -u "$here"/module/* "$out"
    with_cross make -s -C "$src" "M=$out" ARCH=arm64 CROSS_COMPILE=$cross- CC=$cross-gcc-12 CONFIG_GCC_PLUGINS= \
        CONFIG_DEBUG_INFO_BTF_MODULES= CONFIG_CC_HAS_MIN_FUNCTION_ALIGNMENT= modules 2>&1 |
        grep -vE 'compiler differs|kernel was built|You are using|pahole version' || true
    [ -e "$out/gpio-cermd.ko" ]
}

# The makefiles of Debian's headers name absolute paths and their own compiler; their modpost wants a newer libc than
# this host may have.
headers_relocate() {
    local tree=$1 v=$2 lib=$1/usr/lib/x86_64-linux-gnu src mod
    src=$tree/usr/src/linux-headers-$v
    mod=$tree/usr/lib/linux-kbuild-$(kernel_base "$v")/scripts/mod
    printf 'KBUILD_OUTPUT=%s\ninclude %s/Makefile\n' "$src" "$tree/usr/src/linux-headers-$(kernel_common "$v")" >"$src/Makefile"
    printf 'override ARCH = arm64\noverride KERNELRELEASE = %s\noverride CROSS_COMPILE = %s-\n' "$v" $cross \
        >"$src/.kernelvariables"
    printf '#!/bin/sh\nexec %s/ld-linux-x86-64.so.2 --library-path %s %s/modpost.real-lsb-64 "$@"\n' \
        "$lib" "$lib" "$mod" >"$mod/modpost"
    chmod +x "$mod/modpost"
}

# build_c OUTPUT SOURCE [OPTION...]: against the guest's libraries; newer symbols than the compiler's libc has are left
# to the guest.
build_c() {
    local out=$cache/build/$1 src=$here/$2 tree=$cache/tree
    shift 2
    with_cross $cross-gcc-12 --sysroot="$tree/cross" -O2 -Wall -Wextra -Werror -I"$tree/guest/usr/include" \
        -o "$out" "$src" -L"$tree/guest/usr/lib/$cross" -Wl,--allow-shlib-undefined "$@"
}

# The crate's programs and the contract of its backends as for a board, by Debian's rustc of the crate's MSRV and this host's cargo.
build_rust() {
    local bin=$cache/build/bin libs=$cache/tree/rust/usr/lib/x86_64-linux-gnu
    mkdir -p "$bin"
    printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s/tree/rust/usr/bin/rustc "$@"\n' "$libs" "$cache" >"$bin/rustc"
    printf '#!/bin/sh\nPATH=%s:$PATH LD_LIBRARY_PATH=%s exec %s-gcc-12 --sysroot=%s "$@"\n' \
        "$cache/tree/cross/usr/bin" "$cache/tree/cross/usr/lib/x86_64-linux-gnu" $cross "$cache/tree/cross" >"$bin/linker"
    chmod +x "$bin"/*
    printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s-ar "$@"\n' "$cache/tree/cross/usr/lib/x86_64-linux-gnu" "$cache/tree/cross/usr/bin/$cross" >"$bin/ar"
    chmod +x "$bin/ar"
    # One crate has C in it.
    RUSTC=$bin/rustc CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=$bin/linker \
        CC_aarch64_unknown_linux_gnu=$bin/linker AR_aarch64_unknown_linux_gnu=$bin/ar \
        cargo build --quiet --locked --release --bins --example contract --manifest-path "$root_of_crate/Cargo.toml" \
        --target $target --target-dir "$cache/build/target"
}

# build_package: the Debian package of these programs, and a newer one with another configuration file, in $cache/build/packages-vm.
build_package() {
    local out=$cache/build/packages-vm
    rm -rf "$out"
    mkdir -p "$out"
    CERMD_VM_CACHE=$cache "$root_of_crate/packaging/build" --built "$cache/build/target" --out "$out" arm64
    dpkg-deb -R "$out"/cermd_*_arm64.deb "$out/newer"
    sed -i 's/^Version: .*/&+newer/' "$out/newer/DEBIAN/control"
    echo "# Of the newer package." >>"$out/newer/etc/cermd/cermd.toml"
    SOURCE_DATE_EPOCH=1767225600 dpkg-deb --root-owner-group -b "$out/newer" "$out/newer.deb" >/dev/null
    rm -rf "$out/newer"
}

# build_armhf: the archive of static programs for 32-bit boards, in $cache/build/armhf.
build_armhf() {
    rm -rf "$cache/build/armhf"
    CERMD_VM_CACHE=$cache "$root_of_crate/packaging/build" --programs "$cache/build/armhf" armhf
}
