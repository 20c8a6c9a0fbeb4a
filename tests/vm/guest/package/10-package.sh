# From the file of a package to newtons on a Debian that has never seen it: installed, set up, upgraded, disturbed, removed, purged.
. /test/package/service.sh
driver=/sys/bus/platform/drivers/gpio-cermd
# is_inactive WORDS: not failed, not starting again and again, and `systemctl status` has these words for the reason.
is_inactive() {
    sleep 2
    systemctl status --full --no-pager cermd >status 2>&1 || true
    cat status
    [ "$(property ActiveState) $(property NRestarts)" = "inactive 0" ] || fail "it is $(property ActiveState), after $(property NRestarts) restarts"
    grep -F "$1" status >/dev/null || fail "the reason is not told: $1"
}
field() { sed -n "s/.*\"$1\":\([0-9.]*\).*/\1/p" reading; }
# reads OHM: within four standard uncertainties, ohms and newtons (F = 13346 N ohm / R).
reads() {
    until_true 200 settled || fail "no reading that has settled: $(cermctl get --json)"
    cat reading
    mawk -v r="$(field r_ohm)" -v u="$(field r_u_ohm)" -v f="$(field f_n)" -v fu="$(field f_u_n)" -v true="$1" 'BEGIN {
        n = 13346 / true
        print r - true " ohm off, u " u "; " f - n " N off, u " fu
        exit !(u > 0 && u < 0.01 * true && (r - true) ^ 2 < 16 * u * u && fu > 0 && fu < 0.1 * n && (f - n) ^ 2 < 16 * fu * fu)
    }' || fail "that is not $1 ohm"
}
# Where packages and people put files; their names, without what dpkg and apt keep for themselves.
files() {
    find /etc /usr /var /root /home | grep -vE '^/var/(log|cache|lib/(dpkg|apt))/' | sort
}

files >before
now
install /test/cermd_*_arm64.deb
installed=$(ms)
echo "installed after $installed ms"

echo "== not set up"
[ "$(systemctl is-enabled cermd)" = disabled ] || fail "it is enabled: nobody has said what is wired to which line"
stat_of() { /usr/bin/stat -c '%U %G %a' "$1"; }
[ "$(stat_of "/dev/$(chip)")" = "root gpio 660" ] || fail "the rule: $(stat_of "/dev/$(chip)")"
[ "$(stat_of /dev/cpu_dma_latency)" = "cermd root 600" ] || fail "the rule: $(stat_of /dev/cpu_dma_latency)"
for file in $(dpkg -L cermd); do [ -e "$file" ] || fail "$file is not there"; done
systemctl start cermd
is_inactive 'there is no GPIO chip with label, name or path "pinctrl-rp1"'
mv $config /etc/cermd/away
systemctl start cermd
is_inactive "ConditionPathExists=$config"
mv /etc/cermd/away $config
mkdir /dev/away
mv /dev/gpiochip* /dev/away
systemctl start cermd
is_inactive "ConditionPathExistsGlob=/dev/gpiochip*"
mv /dev/away/* /dev
for unit in mqtt prometheus web iio; do
    [ "$(systemctl is-enabled cermd-$unit) $(systemctl is-active cermd-$unit)" = "disabled inactive" ] || fail "cermd-$unit is not left alone"
done
lines_are_safe "not set up"

echo "== set up"
# The sensor behind R_lim; a wire in its place when that is asked for.
circuit r_mohm 2320000,12700000,1220000,0
mkfifo answers
now
cermctl setup --chip cermd-rc --wiring two --c-a "2.2 uF" --c-b "680 nF" --r-c1 "2.32 kohm" --r-c2 "12.7 kohm" --sensor fsr402 \
    <answers >setup 2>&1 &
setup=$!
exec 3>answers
# Both ends are open: it needs no name any more.
rm answers
until_true 2400 grep -q '5. zero' setup || { cat setup; fail "no zero is asked for"; }
echo "a first reading after $(ms) ms"
circuit r_mohm 2320000,12700000,220000,0
echo >&3
exec 3>&-
wait $setup || { cat setup; fail "the setup failed"; }
cat setup
circuit r_mohm 2320000,12700000,1220000,0
sleep 0.5
reads 1000
set_up=$(ms)
echo "set up and zeroed, newtons after $set_up ms"
between $(((installed + set_up) / 1000)) 0 120
timeout -s INT 2 cermctl watch | tee watched | tail -n 3
grep ' N ' watched >/dev/null || fail "cermctl watch shows no newtons"
[ "$(systemctl is-enabled cermd)" = enabled ] || fail "it will not start at the next boot"

echo "== upgraded"
echo "# Mine." >>$config
cp $config mine
pid=$(property MainPID)
install /test/newer.deb
cmp $config mine || fail "what was edited is lost"
tail -n 1 $config.dpkg-dist
dpkg-query --showformat='${Version} ${Status}\n' --show cermd | grep 'newer install ok installed'
[ "$(property MainPID)" != "$pid" ] || fail "the old program still runs"
until_true 100 reading || fail "it does not serve after the upgrade"
reads 1000

echo "== killed"
now
restarts=$(property NRestarts)
systemctl kill --signal=KILL --kill-whom=main cermd
until_true 100 sh -c "[ \"\$(systemctl show --value --property=NRestarts cermd)\" = $((restarts + 1)) ]" || fail "it is not started again"
until_true 100 reading || fail "it does not serve again"
echo "serves again after $(ms) ms"

echo "== the chip goes and comes, under the service and without it"
echo gpio-cermd >$driver/unbind
until_true 100 sh -c "cermctl get --json | grep '\"status\":\"fault\"'" || fail "no fault without a chip"
echo gpio-cermd >$driver/bind
until_true 100 reading || fail "no readings from the chip that is back"
echo gpio-cermd >$driver/unbind
systemctl restart cermd
is_inactive 'there is no GPIO chip with label, name or path "cermd-rc"'
echo gpio-cermd >$driver/bind
until_true 200 reading || { systemctl status --no-pager cermd; fail "the chip that comes does not start it"; }
reads 1000

echo "== removed"
apt-get remove -y cermd </dev/null
lines_are_safe "removed"
[ ! -e /usr/bin/cermd ] && [ ! -e /run/cermd ] || fail "it is not gone"
cmp $config mine || fail "the configuration is gone with it"
echo "== purged"
apt-get purge -y cermd </dev/null
files >after
# The group and the user stay, as numbers must not be given twice.
diff before after | sed -n 's/^> //p' | tee left
left=$(grep -vE '^/etc/((passwd|group|shadow|gshadow)-?|\.pwd\.lock)$' left || true)
[ -z "$left" ] || fail "left behind: $left"
diff before after | sed -n 's/^< //p' | tee missing
[ ! -s missing ] || fail "more is gone than has come"
systemctl --failed --no-legend --plain | tee failed
[ ! -s failed ] || fail "units failed"
