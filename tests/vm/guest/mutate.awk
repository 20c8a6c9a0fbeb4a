# mutate.awk -v mutant=NAME FILE: readings (see judge.awk) as a daemon with a known fault would give them.
mutant == "biased" && $1 > 14000 { $3 += 10 }
mutant == "faulty" && $1 < 200 && NR % 5 == 0 { $2 = "fault" }
mutant == "boastful" { $4 /= 2 }
mutant == "timid" { $4 *= 2 }
{ print }
