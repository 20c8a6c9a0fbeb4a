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
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "lines" -d 'List the GPIO chips and lines of this machine, and who holds which'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "record" -d 'Write readings, or the timings of discharges, to a file'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "estimate" -d 'Estimate again from the timings on a tape'
complete -c cermctl -n "__fish_cermctl_needs_command" -f -a "calibrate" -d 'Measure the zero or the force characteristic of a sensor, and put it into the configuration'
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
complete -c cermctl -n "__fish_cermctl_using_subcommand demo" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -l max-hz -d 'At most so many readings of each channel per second' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -l json -d 'The lines of the stream as they come'
complete -c cermctl -n "__fish_cermctl_using_subcommand watch" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand get" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand get" -l json -d 'The lines of the stream as they come'
complete -c cermctl -n "__fish_cermctl_using_subcommand get" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand stats" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand stats" -l json -d 'The line of the stream as it comes'
complete -c cermctl -n "__fish_cermctl_using_subcommand stats" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand check" -l config -d 'The configuration file' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand check" -s h -l help -d 'Print help'
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
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l config -d 'The configuration file of the daemon; a copy of it is kept when it is changed' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l yes -d 'Change the configuration without asking'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -l json -d 'The result as a line of JSON'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from zero" -s h -l help -d 'Print help'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l count -d 'How many discharges to take' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l channel -d 'Which channel [default: the only one]' -r
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from reference" -l config -d 'The configuration file of the daemon; a copy of it is kept when it is changed' -r -F
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
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l config -d 'The configuration file of the daemon; a copy of it is kept when it is changed' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l socket -d 'The socket of the daemon' -r -F
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l yes -d 'Change the configuration without asking'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -l json -d 'The result as a line of JSON'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from force" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "zero" -d 'With a short circuit in the sensor\'s place: find the zero'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "reference" -d 'With a known resistor in the sensor\'s place: below r-c1 find the zero, from there on the scale'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "force" -d 'With weights on the sensor: find how its resistance becomes force'
complete -c cermctl -n "__fish_cermctl_using_subcommand calibrate; and __fish_seen_subcommand_from help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "demo" -d 'Show live readings of a simulated circuit: no hardware, no root, no daemon, no file left behind'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "watch" -d 'Show readings as they come, a live line per channel; survives a restart of the daemon'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "get" -d 'Print the last reading of each channel'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "stats" -d 'Print what the daemon has counted and learned'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "check" -d 'Say what is wrong with a configuration and, unless cermd holds it, with the circuit: every line is tested'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "lines" -d 'List the GPIO chips and lines of this machine, and who holds which'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "record" -d 'Write readings, or the timings of discharges, to a file'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "estimate" -d 'Estimate again from the timings on a tape'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "calibrate" -d 'Measure the zero or the force characteristic of a sensor, and put it into the configuration'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and not __fish_seen_subcommand_from demo watch get stats check lines record estimate calibrate help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from calibrate" -f -a "zero" -d 'With a short circuit in the sensor\'s place: find the zero'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from calibrate" -f -a "reference" -d 'With a known resistor in the sensor\'s place: below r-c1 find the zero, from there on the scale'
complete -c cermctl -n "__fish_cermctl_using_subcommand help; and __fish_seen_subcommand_from calibrate" -f -a "force" -d 'With weights on the sensor: find how its resistance becomes force'
