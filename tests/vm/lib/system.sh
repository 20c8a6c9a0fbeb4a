# For: root file systems with real systemd and udev: one with the service and rule under test, one that is a Debian as installed,
# with the package under test beside it. Must not know: the tests.
#
# They are unpacked from packages without their maintainer scripts, so the few files that those would have made are made
# here. They are initramfs, too: no disk, so their time is as deterministic as that of the small image.

system_suite=trixie

# image_system: leaves $cache/build/systemd.initrd
image_system() {
    local root=$cache/build/root-systemd
    system_root system "$root"
    rm -rf "$root/usr/share/perl5" "$root/usr/lib/$cross"/perl*
    image_tests "$root" $system_suite
    image_programs "$root"
    system_units "$root"
    pack_initramfs "$root" systemd
}

# image_package: leaves $cache/build/package.initrd. Its dpkg takes every package that is unpacked there for installed; what has
# been unpacked without its scripts has none to run.
image_package() {
    local root=$cache/build/root-package package
    system_root debian "$root"
    mkdir -p "$root/var/lib/dpkg/info"
    cp "$cache/tree/debian.status" "$root/var/lib/dpkg/status"
    for package in $(sed -n 's/^Package: //p' "$root/var/lib/dpkg/status"); do
        : >"$root/var/lib/dpkg/info/$package.list"
    done
    image_tests "$root" $system_suite
    cp "$cache/build/packages-vm"/*.deb "$root/test"
    cp -r "$cache/build/armhf" "$root/test"
    pack_initramfs "$root" package
}

# system_root TREE ROOT
system_root() {
    local root=$2 etc=$2/etc
    rm -rf "$root"
    cp -a "$cache/tree/$1" "$root"
    rm -rf "$root"/usr/share/{doc,man,locale,zoneinfo} "$root/usr/lib/$cross/gconv" "$root/usr/lib/udev/hwdb"*
    cp "$root/usr/share/base-passwd/passwd.master" "$etc/passwd"
    cp "$root/usr/share/base-passwd/group.master" "$etc/group"
    echo "user:x:1000:1000::/tmp:/bin/sh" >>"$etc/passwd"
    echo "user:x:1000:" >>"$etc/group"
    sed 's/:.*/:*:20000:0:99999:7:::/' "$etc/passwd" >"$etc/shadow"
    echo cermd-vm >"$etc/hostname"
    printf '%032x\n' 12648430 >"$etc/machine-id"
    ln -sf /dev/null "$etc/systemd/system/getty.target"
    ln -sf /dev/null "$etc/systemd/system/ldconfig.service"
    ln -s bash "$root/usr/bin/sh.tmp" && mv "$root/usr/bin/sh.tmp" "$root/usr/bin/sh"
    ln -s usr/lib/systemd/systemd "$root/init"
    cp "$here/guest/system/guest-tests.service" "$root/usr/lib/systemd/system"
    mkdir -p "$root/usr/lib/systemd/system/multi-user.target.wants"
    ln -s ../guest-tests.service "$root/usr/lib/systemd/system/multi-user.target.wants"
}

# The service and the rule under test.
system_units() {
    cp "$root_of_crate"/systemd/*.service "$1/usr/lib/systemd/system"
    cp "$root_of_crate"/systemd/cermd.sysusers "$1/usr/lib/sysusers.d/cermd.conf"
    cp "$root_of_crate"/udev/*.rules "$1/usr/lib/udev/rules.d"
}
