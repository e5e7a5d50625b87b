# Doxygen's filter: turns the labelled lines of a contract ("Units   drho kg m^-3 s^-1") into
# paragraphs of their own.
/^ \* (Shape|Units|Fields|Ownership|Parallel|Errors|Source|Since)  *[^ ]/ {
  label = $2
  text = $0
  sub(/^ \* [A-Z][a-z]* */, "", text)
  printf " * @par %s\n * %s\n", label, text
  labelled = 1
  next
}
# Continuation lines are indented to stand below the text; Doxygen would take them for code.
labelled && /^ \*      *[^ ]/ { sub(/^ \* */, " * ") }
/\*\// { labelled = 0 }
{ print }
