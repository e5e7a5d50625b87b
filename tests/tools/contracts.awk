# Every public function has a contract.
#
#   awk -f contracts.awk HEADER...
#
# The comment right before each SPH_API declaration starts with /** and has the lines Parallel,
# Errors and Since; each header has an @file comment.
function wrong(line, text) {
  printf "%s:%d: %s\n", FILENAME, line, text
  failed = 1
}

function finish_file() {
  if (previous != "" && !described) {
    printf "%s:1: no /** @file comment\n", previous
    failed = 1
  }
}

FNR == 1 {
  finish_file()
  previous = FILENAME
  described = 0
  comment = ""
  inside = 0
}

/@file/ { described = 1 }

/^[ \t]*\/\*\*/ {
  comment = ""
  inside = 1
}
inside {
  comment = comment "\n" $0
  if (/\*\//) inside = 0
  next
}

/^SPH_API/ {
  name = $0
  if (name !~ /sph_[a-z0-9_]+\(/) { # the name is on the next line
    getline
    name = name " " $0
  }
  match(name, /sph_[a-z0-9_]+\(/)
  name = substr(name, RSTART, RLENGTH - 1)
  functions++
  if (comment == "") wrong(FNR, name " has no /** comment")
  else {
    if (comment !~ /\n \* Parallel /) wrong(FNR, name ": the contract has no line Parallel")
    if (comment !~ /\n \* Errors /) wrong(FNR, name ": the contract has no line Errors")
    if (comment !~ /\n \* Since /) wrong(FNR, name ": the contract has no line Since")
  }
  comment = ""
  next
}

# A contract belongs to the declaration that follows at once.
!/^[ \t]*$/ { comment = "" }

END {
  finish_file()
  if (failed) exit 1
  printf "%d public functions have their contract\n", functions
}
