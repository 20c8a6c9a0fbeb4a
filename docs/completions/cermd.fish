complete -c cermd -l config -d 'The configuration file, see cermd.toml(5)' -r -F
complete -c cermd -l check -d 'Check the configuration, say what is found, and exit'
complete -c cermd -l release-lines -d 'Make every line an input that was asked for, and exit: for after a kill. Where $RUNTIME_DIRECTORY does not tell, those that the configuration names'
complete -c cermd -s h -l help -d 'Print help'
complete -c cermd -s V -l version -d 'Print version'
