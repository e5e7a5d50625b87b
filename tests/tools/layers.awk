# Who may include whom.
#
#   awk -f layers.awk FILE...
#
# libsph/x/ may include <...>, its own folder, and of the folders above it in `order` core/, sweep/
# and <stem>_impl.h. Public headers include only three standard headers and <sph/...>. Examples
# see the public headers alone; tests may look inside.
BEGIN {
  count = split("core kernel wave paddle body solver mesh particles sweep search wall interpolator boundary " \
                "integrator wcsph isph flip probe output initial", order, " ")
  for (k = 1; k <= count; k++) rank[order[k]] = k
}

function wrong(text) {
  printf "%s:%d: %s\n", FILENAME, FNR, text
  failed = 1
}

function library(name, quoted,    me, it, parts) {
  if (!quoted) return
  split(FILENAME, parts, "/")
  me = parts[2]
  if (!(me in rank)) {
    wrong("folder " me " has no place in the order of tests/tools/layers.awk")
    return
  }
  if (name !~ /\// || name == "sweep/vreal.h") return # the folder's own, or everybody's
  it = name
  sub(/\/.*/, "", it)
  if (it == me) return
  if (!(it in rank)) {
    wrong("\"" name "\" is in no folder of the library")
    return
  }
  if (it != "core" && it != "sweep" && name !~ /_(impl|list)\.h$/)
    wrong("\"" name "\" is private to " it "; only *_impl.h and *_list.h may be included from " me)
  if (rank[it] > rank[me])
    wrong("\"" name "\": " it " is below " me " in the order of layers")
}

function public_header(name, quoted) {
  if (quoted || name !~ /^(sph\/[a-z_]+\.h|stddef\.h|stdint\.h|stdbool\.h)$/)
    wrong("a public header includes only <sph/...> and <stddef.h> <stdint.h> <stdbool.h>, not " name)
}

function outsider(name, quoted) {
  if (quoted && name ~ /^(\.\.\/)*(libsph\/|[a-z_]+\/internal\.h|[a-z_]+\/[a-z_]*_impl\.h|sweep\/)/)
    wrong("\"" name "\" is internal; examples use the public headers")
}

/^[ \t]*#[ \t]*include[ \t]*[<"]/ {
  name = $0
  sub(/^[ \t]*#[ \t]*include[ \t]*/, "", name)
  quoted = substr(name, 1, 1) == "\""
  name = substr(name, 2)
  sub(/[>"].*/, "", name)
  checked++
  if (FILENAME ~ /^libsph\//) library(name, quoted)
  else if (FILENAME ~ /^include\//) public_header(name, quoted)
  else if (FILENAME !~ /^tests\//) outsider(name, quoted)
}

END {
  if (failed) exit 1
  printf "%d includes respect the layers\n", checked
}
