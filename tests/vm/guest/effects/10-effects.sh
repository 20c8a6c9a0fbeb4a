# What the daemon reads of a circuit that is not as the law has it, one thing at a time, by the judge that judges it otherwise.
# What the judge accepts is asserted. Of the others the page tells what they do: "fails today", until somebody mends it.
. /test/lib.sh
. /test/accuracy.sh
ohms="100 1000 5000 16200"
count=60

# measured METHOD CONFIGURATION: the files METHOD and METHOD.readings; with a failure where it does not serve.
measured() {
    set -e
    begin method="$1"
    column "$1" $count "$ohms"
    finish
    rm tape
    judge "$1" $([ "$1" = cerm ] && echo defect || echo shared)
}

# effect HOLDS|FAILS WHAT PARAMETER=VALUE...: WHAT of the module is changed; a row for each method. HOLDS: for which methods
# the judge has to accept it: both, cerm, tracked, or none.
effect() {
    holds=$1 what=$2
    shift 2
    for method in cerm tracked; do
        rmmod gpio-cermd
        insmod /test/gpio-cermd.ko late_ns=6000 jitter_ns=1500 "$@"
        rm -f $method $method.readings
        set +e
        (measured $method) >words 2>&1
        status=$?
        set -e
        cat words
        verdict=holds
        [ $status = 0 ] || verdict="**fails**"
        [ -s $method ] || echo "0 nan nan nan 0 0 0 0 0" >$method
        {
            printf '| %s | %s |' "$what" $method
            mawk '{ printf " %.2f (%.2f) |", $2, $4; n += $6; within += $9; faults += $8 }
                END { printf " %.0f %% | %d of %d |", n ? 100 * within / n : 0, faults, n + faults }' $method
            echo " $verdict |"
        } | tee -a rows
        case $holds:$method in
        both:* | cerm:cerm | tracked:tracked) [ $status = 0 ] || bad="$bad $what ($method);" ;;
        esac
    done
}

bad=
effect both "nothing"
effect cerm "a line moves 1 us later after a rest" stall_ns=1000
effect none "2 us" stall_ns=2000
effect none "5 us" stall_ns=5000
effect both "hysteresis, high again at half the progress" hysteresis_pf=240000,410000
effect both "leakage of 10 Mohm at A" leak_kohm=10000,0
effect both "leakage of 30 Mohm at B" leak_kohm=0,30000
effect none "sensor pin of 42 ohm" ro_mohm=40000,40000,42000,40000
effect none "pin of Rc1 of 42 ohm" ro_mohm=42000,40000,40000,40000
effect both "1 of 200 interrupts 10 us later or more" tail_ppm=5000 tail_ns=10000
effect both "absorption of 0.05 %, 1 ms" absorbed_ppm=500 absorbed_tau_us=1000
effect none "absorption of 0.25 %, 1 ms" absorbed_ppm=2500 absorbed_tau_us=1000

{
    echo "## Linux $(uname -r)"
    printf '\n|  | method |'
    for ohm in $ohms; do printf ' %s ohm: bias (u) |' $ohm; done
    printf ' within 2 u | no number | the judge |\n|---|---|--:|--:|--:|--:|--:|--:|---|\n'
    cat rows
} >effects.md
cat effects.md
[ -z "$bad" ] || fail "held, and does no more: $bad"
