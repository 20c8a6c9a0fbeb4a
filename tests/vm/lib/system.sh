# For: the root file system with real systemd and udev, the service and rule under test. Must not know: the tests.
#
# It is unpacked from packages without their maintainer scripts, so the few files that those would have made are made
# here. It is an initramfs, too: no disk, so its time is as deterministic as that of the small image.

system_suite=trixie

# image_system: leaves $cache/build/systemd.initrd
image_system() {
    local root=$cache/build/root-systemd etc=$cache/build/root-systemd/etc
    rm -rf "$root"
    cp -a "$cache/tree/system" "$root"
    rm -rf "$root"/usr/share/{doc,man,locale,perl5,zoneinfo} "$root/usr/lib/$cross"/{gconv,perl*} \
        "$root/usr/lib/udev/hwdb"*
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
    image_tests "$root" $system_suite
    system_units "$root"
    pack_initramfs "$root" systemd
}

# The service and the rule under test, and the unit that runs the tests.
system_units() {
    local units=$1/usr/lib/systemd/system
    cp "$here/guest/system/guest-tests.service" "$units"
    mkdir -p "$units/multi-user.target.wants"
    ln -s ../guest-tests.service "$units/multi-user.target.wants"
    cp "$root_of_crate"/systemd/*.{service,socket} "$units" 2>/dev/null || true
    cp "$root_of_crate"/systemd/cermd.sysusers "$1/usr/lib/sysusers.d/cermd.conf"
    cp "$root_of_crate"/udev/*.rules "$1/usr/lib/udev/rules.d" 2>/dev/null || true
}
