complete -c cermd -l config -d 'The configuration file' -r -F
complete -c cermd -l check -d 'Check the configuration, say what is found, and exit'
complete -c cermd -l release-lines -d 'Make every line that the configuration names an input, and exit: for after a kill'
complete -c cermd -s h -l help -d 'Print help'
complete -c cermd -s V -l version -d 'Print version'
