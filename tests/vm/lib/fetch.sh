# For: everything that the tests take from Debian, each part a tree below $cache/tree. Versions are resolved, never
# written down. Must not know: how the parts are put together.

# The kernels that are tested: GPIO uAPI v1 and v2; v2 only, newer; and one that runs interrupts in threads.
kernels=(trixie trixie-backports trixie-rt)

fetch() {
    if [ -e "$cache/fetched" ] && [ "$(cat "$cache/fetched")" = "$(fetch_recipe)" ]; then return; fi
    apt_new bookworm "amd64 arm64" bookworm bookworm-updates bookworm-backports
    apt_new trixie "amd64 arm64" trixie trixie-backports
    apt_new guest arm64 trixie
    fetch_host
    local kernel
    for kernel in "${kernels[@]}"; do fetch_kernel "$kernel"; done
    fetch_guest
    fetch_recipe >"$cache/fetched"
}

fetch_recipe() { cat "$here/lib/fetch.sh" "$here/lib/apt.sh" | sha256sum; }

# What runs here: the emulator, and compilers for arm64 from the release whose glibc any later Debian can run and
# any later board has.
fetch_host() {
    local rust
    apt_tree bookworm cpio cpio
    apt_closure bookworm qemu -t bookworm-backports qemu-system-arm
    apt_closure bookworm cross gcc-12-aarch64-linux-gnu libc6-dev-arm64-cross make
    # This host's own glibc serves these programs: two of different age in one process do not go together.
    rm -f "$cache"/tree/{qemu,cross}/lib/x86_64-linux-gnu/{libc,libm,libpthread,libdl,librt,ld-linux-x86-64}.so.*
    rust=$(APT_CONFIG=$cache/apt/bookworm/conf apt-cache depends --recurse --important rustc-web |
        grep -oE '^(libstd-rust-web-[0-9.]+|libllvm[0-9]+)$')
    # shellcheck disable=SC2086 # one package a word
    apt_tree bookworm rust rustc-web $rust libstd-rust-web-dev libstd-rust-web-dev:arm64
}

# fetch_kernel KERNEL: the kernel and what modules are built with (its tools for amd64 run on their own libc).
fetch_kernel() {
    local v base common image
    v=$(apt_kernel trixie "$1")
    base=$(kernel_base "$v")
    common=$(kernel_common "$v")
    image=("linux-image-$v:arm64")
    # Newer packages keep the image itself and its modules apart.
    if APT_CONFIG=$cache/apt/trixie/conf apt-cache show "linux-binary-$v:arm64" >/dev/null 2>&1; then
        image=("linux-binary-$v:arm64" "linux-modules-$v:arm64")
    fi
    apt_tree trixie "kernel-$1" "${image[@]}"
    apt_tree trixie "headers-$1" "linux-headers-$v:arm64" "linux-headers-$common" "linux-kbuild-$base" \
        libc6:amd64 libelf1t64:amd64 libzstd1:amd64 zlib1g:amd64
    echo "$v" >"$cache/tree/kernel-$1.version"
}

# Of 6.12.1-cloud-arm64 or 6.12.1-rt-arm64 the tools are those of 6.12.1, the headers of 6.12.1-common or 6.12.1-common-rt.
kernel_base() { echo "${1%-*-arm64}"; }
kernel_common() { case $1 in *-rt-arm64) echo "$(kernel_base "$1")-common-rt" ;; *) echo "$(kernel_base "$1")-common" ;; esac; }

# What runs there: the small image has libgpiod and its tools beside busybox, another one systemd and udev; and what any Debian has.
fetch_guest() {
    apt_closure guest guest busybox-static gpiod libgpiod-dev libgcc-s1 mawk
    apt_closure guest system base-files base-passwd bash coreutils dash dbus findutils gpiod grep gzip hostname kmod \
        libgcc-s1 mawk mount passwd procps sed systemd-sysv tar udev util-linux
    apt_closure guest debian '?essential' apt dbus gpiod kmod libgcc-s1 mawk mount passwd procps systemd-sysv udev
}
