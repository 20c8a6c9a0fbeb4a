# What the unmodified daemon reads over its socket, against what is true.
. /test/lib.sh
. /test/accuracy.sh

ohms="100 121 147 178 215 261 316 383 464 562 681 825 1000 1210 1470 1780 2150 2610 3160 3830 4640 5620 6810 8250 10000
12100 14700 16200"
few="100 316 1000 3160 10000 16200"
count=60
# The newest kernel has the whole table, the other one the comparison of backends.
case $(uname -r) in 6.*) ohms=$few ;; esac

v1=no
! probe v1 || v1=yes

# within_limits FILE: 1 ohm at 100 ohm, 0.1 % from 1 kohm.
within_limits() {
    mawk '{ bias = $2 < 0 ? -$2 : $2 }
        $1 == 100 && bias >= 1 || $1 >= 1000 && bias >= $1 / 1000 { print "over the limit:", $0; bad = 1 }
        END { exit bad }' "$1" || fail "$1: biased"
}

# offset_is_true: what the daemon has found, against what the circuit exports; two standard uncertainties of both.
offset_is_true() {
    read -r truth u_truth <<-END
	$(true_offset)
	END
    echo "$1: found $(stat offset_ns) +- $(stat offset_u_ns), true $truth +- $u_truth" | tee -a offsets
    mawk -v d="$(stat offset_ns)" -v u="$(stat offset_u_ns)" -v t="$truth" -v v="$u_truth" \
        'BEGIN { exit !((d - t) ^ 2 <= 4 * (u * u + v * v)) }'
}

# as_predicted FILE: without correction, -(2 d/(g_A+g_B)) (Rc2-Rx)/(Rc2+Ro), where the switched equation was used. Three
# standard uncertainties of the mean and of the true d.
as_predicted() {
    mawk -v d="$truth" -v u="$u_truth" '$7 == $6 {
        by = -2e-9 / 1.303013e-6 * (12700 - $1) / 12740
        u2 = $3 * $3 / $6 + (by * u) ^ 2
        printf "%d ohm: %.2f +- %.2f, predicted %.2f\n", $1, $2, sqrt(u2), by * d
        if (($2 - by * d) ^ 2 > 9 * u2) bad = 1
        n++
    }
    END { exit bad || !n }' "$1" >"$1.txt" || status=$?
    cat "$1.txt"
    [ -z "${status-}" ] || fail "the bias without correction is not the predicted one"
}

circuit late_ns 6000
circuit jitter_ns 1500
for method in tpcm tcdic; do
    begin method=$method "offset=0 us"
    column $method $count "$ohms"
    stop_cermd
done
begin method=cerm
offset_is_true "late 6000 ns" || fail "the offset is not the true one"
column cerm $count "$ohms"
stop_cermd
within_limits cerm
begin method=cerm "offset=0 us" "t_l=2 ms"
column uncorrected $count "$few"
stop_cermd
as_predicted uncorrected

begin method=cerm chargers=no
column cerm-paper $count "$few"
stop_cermd
within_limits cerm-paper
if [ $v1 = yes ]; then
    begin method=cerm backend=chardev-v1
    column cerm-v1 $count "$few"
    stop_cermd
    within_limits cerm-v1
fi

circuit late_ns 0
circuit jitter_ns 0
begin method=cerm
offset_is_true "late 0 ns" || echo "not within two standard uncertainties"
column cerm-quiet $count "$few"
stop_cermd
within_limits cerm-quiet
[ "$(cat $parameters/conflicts)" = 0 ] || fail "lines drove against each other"

{
    echo "## Linux $(uname -r)"
    table "Interrupts 6 us late, standard deviation 1.5 us (as assumed for a board), $count readings each:" tpcm tcdic cerm
    printf '\nThe offset of cerm, ns, with standard uncertainties:\n\n'
    sed 's/^/    /' offsets
    printf '\nThe bias of cerm with `offset = "0 us"`, ohm:\n\n'
    sed 's/^/    /' uncorrected.txt
    others="cerm-paper cerm-quiet"
    [ $v1 = no ] || others="cerm-paper cerm-v1 cerm-quiet"
    # shellcheck disable=SC2086 # one word a column
    table "Beside it: sense lines that charge (the wiring of the paper), uAPI v1 where the kernel has it, and dedicated \
chargers without any noise but the kernel's own:" $others
} >accuracy.md
