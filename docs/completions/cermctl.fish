# Print an optspec for argparse to handle cmd's options that are independent of any subcommand.
function __fish_cermctl_global_optspecs
    string join \n h/help V/version
end

function __fish_cermctl_needs_command
    # Figure out if the current invocation already has a command.
    set -l cmd (commandline -opc)
    set -e cmd[1]
    argparse -s (__fish_cermctl_global_optspecs) -- $cmd 2>/dev/null
    or return
    if set -q argv[1]
        # Also print the command, so this can be used to figure out what it is.
        echo $argv[1]
        return 1
    end
    return 0
end

function __fish_cermctl_using_subcommand
    set -l cmd (__fish_cermctl_needs_command)
    test -z "$cmd"
    and return 1
    contains -- $cmd[1] $argv
end

complete -c cermctl -n "__fish_cermctl_needs_command" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_needs_command" -s V -l version -d 'Print version'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "demo" -d 'Show live readings of a simulated circuit: no hardware, no root, no daemon, no file left behind'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "watch" -d 'Show readings as they come, a live line per channel; survives a restart of the daemon'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "get" -d 'Print the last reading of each channel'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "stats" -d 'Print what the daemon has counted and learned'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "check" -d 'Say what is wrong with a configuration and, unless cermd holds it, with the circuit: every line is tested'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "size" -d 'Find the circuit for a sensor: capacitors, resistors and settings for a wanted error or rate, with what to expect of it'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "lines" -d 'List the GPIO chips and lines of this machine, and who holds which'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "record" -d 'Write readings, or the timings of discharges, to a file'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "estimate" -d 'Estimate again from the timings on a tape'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "calibrate" -d 'Measure the zero or the force characteristic of a sensor, and put it into the configuration'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "characterize" -d 'Measure error against time of every method, circuit and mean, and where they fail: simulated, live, or from a tape'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "zero" -d 'Tare: what lies on a sensor now counts as no force (the zero of its resistance is `calibrate zero`)'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "setup" -d 'Set the instrument up, from wires to the first reading: chip, configuration, test, service, zero; --undo takes it back'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "bridge" -d 'Tell another system what cermd reads, until Ctrl-C; survives restarts of both'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "web" -d 'Serve a page for browsers: every channel live, and the health of the instrument'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -l scene -d 'The simulated board: ideal, fpga-paper, pi-zero, pi4 or pi5, with a hand pressing an FSR 402; or a scene file (*.toml) with its own sensors' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -l seconds -d 'How long to measure' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -l seed -d 'Of every random number [default: the scene\'s own]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -l method -d 'How to estimate [default: the best that the circuit allows]' -r -f -a "tpcm\t''
qerm\t''
tcdic\t''
cerm\t''
tracked\t''"
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -l wiring -d 'How it is wired [default: as the scene, or as the method needs it]' -r -f -a "one\t'One capacitor: least parts, most readings a second'
two\t'Two capacitors: each reading can be checked by a second crossing'
series\t'One capacitor, Rc2 in series with Rc1: for qerm'"
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -l unit -d 'What forces are shown in; a mass stands for its weight' -r -f -a "N\t''
g\t''
kg\t''
lbf\t''"
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -l compare -d 'All methods side by side on the same sensor: what each reads, how far off it is, how fast; then error against time. On anything but a terminal as fast as it can be computed'
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -l max-hz -d 'At most so many readings of each channel per second' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -l unit -d 'What forces are shown in; a mass stands for its weight' -r -f -a "N\t''
g\t''
kg\t''
lbf\t''"
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -l json -d 'The lines of the stream as they come'
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand get" -l unit -d 'What forces are shown in; a mass stands for its weight' -r -f -a "N\t''
g\t''
kg\t''
lbf\t''"
complete -c cermctl -n "__fish_cermctl_using_subcommand get" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand get" -l json -d 'The lines of the stream as they come'
complete -c cermctl -n "__fish_cermctl_using_subcommand get" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand stats" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand stats" -l json -d 'The line of the stream as it comes'
complete -c cermctl -n "__fish_cermctl_using_subcommand stats" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand check" -l config -d 'The configuration file, see cermd.toml(5)' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand check" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l r -d 'From the least to the greatest resistance of the sensor, such as 100ohm..100kohm' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l sensor -d 'A sensor whose range is that of its forces' -r -f -a "fsr402\t'Force-sensing resistor, F = 13.3 kN ohm / R'"
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l force -d 'From the least to the greatest force, such as 0.2N..20N' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l error -d 'How uncertain a reading may be, 1 sigma: of the reading, in ohm or in newton, such as 0.5%, 2ohm or 0.02N [default: as little as the rate allows]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l rate -d 'Readings per second at the least, such as 200Hz [default: as many as the error allows]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l scene -l board -d 'The board: pi4, pi5 or pi-zero, or a scene file (*.toml) whose noise was measured' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l pin-current -d 'What a pin may carry, such as 8mA [default: 16 mA of a pi-zero, 12 mA of a pi5, 8 mA else]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l have -d 'Build from these capacitors and calibration resistors, as many of each as it takes, such as "2.2uF, 680nF, 470ohm, 10kohm" [default: film capacitors of E12, resistors of E96]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l wiring -d 'How it is wired [default: whatever is better]' -r -f -a "one\t'One capacitor: least parts, most readings a second'
two\t'Two capacitors: each reading can be checked by a second crossing'
series\t'One capacitor, Rc2 in series with Rc1: for qerm'"
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l write -d 'Write a configuration for the circuit, with comments on what to measure; the file must not be there yet' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -l json -d 'The result as a line of JSON'
complete -c cermctl -n "__fish_cermctl_using_subcommand size" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c cermctl -n "__fish_cermctl_using_subcommand lines" -l json -d 'One object for each chip'
complete -c cermctl -n "__fish_cermctl_using_subcommand lines" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand record" -l seconds -d 'Stop after so long [default: at Ctrl-C]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand record" -l count -d 'Stop after so many readings, or discharges with --raw' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand record" -l format -d 'How to write readings' -r -f -a "ndjson\t'The lines of the stream as they come'
csv\t'A line of names, then one line per reading; what is not known is empty'"
complete -c cermctl -n "__fish_cermctl_using_subcommand record" -s o -l output -d 'Where to write; an existing file is replaced [default: standard output]' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand record" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand record" -l raw -d 'A tape: the timings of the discharges in the place of readings, for `cermctl estimate`'
complete -c cermctl -n "__fish_cermctl_using_subcommand record" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c cermctl -n "__fish_cermctl_using_subcommand estimate" -l method -d 'How to estimate; several times for several methods beside each other' -r -f -a "tpcm\t''
qerm\t''
tcdic\t''
cerm\t''
tracked\t''"
complete -c cermctl -n "__fish_cermctl_using_subcommand estimate" -l offset -d 'How late the kernel stamps a crossing: a duration such as "8 us", or auto for what the split calibration discharges on the tape tell [default: what the tape says, or else auto]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand estimate" -l summary -d 'What all estimates come to, in the place of each: for each channel and method how many numbers, their mean, their standard deviation, the uncertainty that they state, and the root mean square of their deviations in units of that'
complete -c cermctl -n "__fish_cermctl_using_subcommand estimate" -l json -d 'The summary as lines of JSON, as estimates always are'
complete -c cermctl -n "__fish_cermctl_using_subcommand estimate" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and not __fish_seen_subcommand_from zero reference force help" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and not __fish_seen_subcommand_from zero reference force help" -f -a "zero" -d 'With a short circuit in the sensor\'s place: find the zero'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and not __fish_seen_subcommand_from zero reference force help" -f -a "reference" -d 'With a known resistor in the sensor\'s place: below r-c1 find the zero, from there on the scale'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and not __fish_seen_subcommand_from zero reference force help" -f -a "force" -d 'With weights on the sensor: find how its resistance becomes force'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and not __fish_seen_subcommand_from zero reference force help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l count -d 'How many discharges to take' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l channel -d 'Which channel [default: the only one]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l config -d 'The configuration file, see cermd.toml(5)' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l yes -d 'Change the configuration without asking'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l json -d 'The result as a line of JSON'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l count -d 'How many discharges to take' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l channel -d 'Which channel [default: the only one]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l config -d 'The configuration file, see cermd.toml(5)' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l yes -d 'Change the configuration without asking'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l json -d 'The result as a line of JSON'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l csv -d 'Pairs from a file of `force_n,r_ohm` lines [default: typed; the resistance is measured]' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l model -d 'What to fit' -r -f -a "alpha\t'R = alpha / F'
power\t'F = F_1k (R / 1 kohm)^-exponent'
table\t'The pairs themselves, and interpolation between them'"
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l plot -d 'Draw pairs, fit and residuals into this file, as SVG' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l count -d 'How many readings to average for each weight' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l channel -d 'Which channel [default: the only one]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l config -d 'The configuration file, see cermd.toml(5)' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l yes -d 'Change the configuration without asking'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l json -d 'The result as a line of JSON'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "zero" -d 'With a short circuit in the sensor\'s place: find the zero'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "reference" -d 'With a known resistor in the sensor\'s place: below r-c1 find the zero, from there on the scale'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "force" -d 'With weights on the sensor: find how its resistance becomes force'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l out -d 'The folder for points.csv, provenance.json and the report. What is there already is not measured again' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l scene -d 'The simulated board: ideal, fpga-paper, pi-zero, pi4 or pi5, or a scene file (*.toml) [default: pi4]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l config -d 'Read as this configuration says. With a circuit on GPIO lines, and without --scene: that circuit, with known resistors for which it asks, one after the other' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l tape -d 'What was recorded with a known resistor on each channel' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l truth -d 'The resistor of a channel of the tape as measured, such as thumb=997.3; several times for several channels' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l method -d 'Only these methods [default: all that a circuit allows]' -r -f -a "tpcm\t''
qerm\t''
tcdic\t''
cerm\t''
tracked\t''"
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l circuit -d 'Only these wirings [default: all that the scene has capacitors for]' -r -f -a "one\t'One capacitor: least parts, most readings a second'
two\t'Two capacitors: each reading can be checked by a second crossing'
series\t'One capacitor, Rc2 in series with Rc1: for qerm'"
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l r -d 'Only these resistances, such as "100 ohm,4.7 kohm" [default: four over the range; live: as they are typed]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l average -d 'Only means over these times, such as "0 s,100 ms"; 0 s: each reading [default: each, and 10 ms to 10 s; live: each, and 1 s]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l instruments -d 'So many simulated instruments for each point, each on a board of its own [default: as many as there is time for]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l seed -d 'Of the first of them [default: the scene\'s own]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -l maps -d 'The maps of where methods fail, too [default: unless --method, --circuit, --r or --average is given; not of fpga-paper]'
complete -c cermctl -n "__fish_cermctl_using_subcommand characterize" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l count -d 'How many readings to average' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l unit -d 'What forces are shown in; a mass stands for its weight' -r -f -a "N\t''
g\t''
kg\t''
lbf\t''"
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l channel -d 'Which channel [default: the only one]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l config -d 'The configuration file, see cermd.toml(5)' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l clear -d 'Take the tare away: all that lies on the sensor counts again'
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l yes -d 'Change the configuration without asking'
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -l json -d 'The result as a line of JSON'
complete -c cermctl -n "__fish_cermctl_using_subcommand zero" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l chip -d 'The GPIO chip, by label, name or path [default: that of a Raspberry Pi\'s header]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l scene -d 'A simulated board in the place of a chip: ideal, fpga-paper, pi-zero, pi4 or pi5' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l wiring -d 'Capacitors: one, or two' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l c-a -d 'C_A as printed, such as "2.2 uF"' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l c-b -d 'C_B as printed' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l c -d 'The only capacitor as printed' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l r-c1 -d 'Rc1 as measured, such as "468.2 ohm"' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l r-c2 -d 'Rc2 as measured' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l r-charge -d 'Rp of a charger and its pin, such as "260 ohm" [default: by the chip, as hw/wiring.md has it]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l sensor -d 'What is measured: fsr402 for force by its data sheet, ohm for resistance alone' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l id -d 'The name of the sensor in the stream' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l set -d 'Any other value of the configuration, such as gpio.sense-a=GPIO17 or channel.law.kind=pt1000; several times for several' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l config -d 'The configuration file, see cermd.toml(5)' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l yes -d 'Ask nothing: what no option says is as on the drawings'
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l undo -d 'Take it back: the service stopped, the configuration as it was before'
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -l no-service -d 'Write and test the configuration, and leave the service alone'
complete -c cermctl -n "__fish_cermctl_using_subcommand setup" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and not __fish_seen_subcommand_from prometheus mqtt iio help" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and not __fish_seen_subcommand_from prometheus mqtt iio help" -f -a "prometheus" -d 'Serve a page of metrics for Prometheus, as text and as OpenMetrics'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and not __fish_seen_subcommand_from prometheus mqtt iio help" -f -a "mqtt" -d 'Publish on an MQTT broker what changes beyond its uncertainty; Home Assistant shows it without being configured'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and not __fish_seen_subcommand_from prometheus mqtt iio help" -f -a "iio" -d 'Serve the channels as an IIO device: for iio_info, iio_attr, iio_readdev and whatever else speaks with iiod'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and not __fish_seen_subcommand_from prometheus mqtt iio help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from prometheus" -l listen -d 'Where to listen; the page is /metrics. For other machines: 0.0.0.0:9839' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from prometheus" -l host -d 'Also answer under this host name; addresses, localhost and the name of this machine need no mention' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from prometheus" -l stale -d 'A reading that is older is told no more: the channel is then of unknown state' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from prometheus" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from prometheus" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l broker -d 'Name or address of the broker' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l port -d 'Its port [default: 1883, with TLS 8883]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l ca -d 'The same with the certificate authorities in this file (PEM), and no others' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l user -d 'Log in as this user' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l password-file -d 'A file whose first line is the password; nobody else should be able to read it' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l id -d 'What this board is called on the broker, where no other may have the same name: letters, digits, - and _ [default: the name of this machine]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l discovery -d 'The first level of the topics on which Home Assistant listens for new devices' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l change -d 'Tell a resistance that has changed by so many of its standard uncertainties; at 3, noise alone tells one reading in 30' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l every -d 'Tell every channel at least so often' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l at-most-every -d 'Tell a channel whose state stays at most so often' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l stale -d 'A reading that is older is told no more: the channel is then of unknown state' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l tls -d 'Encrypt, and believe brokers that the authorities of this machine vouch for: /etc/ssl/certs/ca-certificates.crt'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -l no-discovery -d 'Announce nothing to Home Assistant'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from mqtt" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from iio" -l listen -d 'Where to listen, for iio_info -u ip:127.0.0.1. For other machines: 0.0.0.0:30431' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from iio" -l stale -d 'A reading that is older is told no more: the channel is then of unknown state' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from iio" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from iio" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from help" -f -a "prometheus" -d 'Serve a page of metrics for Prometheus, as text and as OpenMetrics'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from help" -f -a "mqtt" -d 'Publish on an MQTT broker what changes beyond its uncertainty; Home Assistant shows it without being configured'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from help" -f -a "iio" -d 'Serve the channels as an IIO device: for iio_info, iio_attr, iio_readdev and whatever else speaks with iiod'
complete -c cermctl -n "__fish_cermctl_using_subcommand bridge; and __fish_seen_subcommand_from help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand web" -l listen -d 'Where to listen. For other machines: 0.0.0.0:8390' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand web" -l host -d 'Also answer under this host name; addresses, localhost and the name of this machine need no mention' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand web" -l stale -d 'A reading that is older is told no more: the channel is then of unknown state' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand web" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand web" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "demo" -d 'Show live readings of a simulated circuit: no hardware, no root, no daemon, no file left behind'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "watch" -d 'Show readings as they come, a live line per channel; survives a restart of the daemon'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "get" -d 'Print the last reading of each channel'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "stats" -d 'Print what the daemon has counted and learned'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "check" -d 'Say what is wrong with a configuration and, unless cermd holds it, with the circuit: every line is tested'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "size" -d 'Find the circuit for a sensor: capacitors, resistors and settings for a wanted error or rate, with what to expect of it'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "lines" -d 'List the GPIO chips and lines of this machine, and who holds which'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "record" -d 'Write readings, or the timings of discharges, to a file'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "estimate" -d 'Estimate again from the timings on a tape'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "calibrate" -d 'Measure the zero or the force characteristic of a sensor, and put it into the configuration'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "characterize" -d 'Measure error against time of every method, circuit and mean, and where they fail: simulated, live, or from a tape'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "zero" -d 'Tare: what lies on a sensor now counts as no force (the zero of its resistance is `calibrate zero`)'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "setup" -d 'Set the instrument up, from wires to the first reading: chip, configuration, test, service, zero; --undo takes it back'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "bridge" -d 'Tell another system what cermd reads, until Ctrl-C; survives restarts of both'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "web" -d 'Serve a page for browsers: every channel live, and the health of the instrument'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check size lines record estimate calibrate characterize zero setup bridge web help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from calibrate" -f -a "zero" -d 'With a short circuit in the sensor\'s place: find the zero'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from calibrate" -f -a "reference" -d 'With a known resistor in the sensor\'s place: below r-c1 find the zero, from there on the scale'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from calibrate" -f -a "force" -d 'With weights on the sensor: find how its resistance becomes force'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from bridge" -f -a "prometheus" -d 'Serve a page of metrics for Prometheus, as text and as OpenMetrics'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from bridge" -f -a "mqtt" -d 'Publish on an MQTT broker what changes beyond its uncertainty; Home Assistant shows it without being configured'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from bridge" -f -a "iio" -d 'Serve the channels as an IIO device: for iio_info, iio_attr, iio_readdev and whatever else speaks with iiod'
