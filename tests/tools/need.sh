#!/bin/sh
# Installs the Debian packages that the named needs lack.
#
#   need.sh NEED...
#
# Every need is probed; only what is missing is installed, by root or through a sudo that asks no
# password. Otherwise the command is printed and the exit status is 1.
set -u
compiler=${CC:-gcc}
includes() {
  printf '#include <%s>\nint main(void) { return 0; }\n' "$1" | $compiler -x c -fsyntax-only - >/dev/null 2>&1
}
has() { command -v "$1" >/dev/null 2>&1; }

missing=""
lacking() {
  missing=""
  for need in "$@"; do
    case $need in
      cc) includes stdio.h || missing="$missing gcc libc6-dev" ;;
      make) has make || missing="$missing make" ;;
      pkg-config) has pkg-config || missing="$missing pkg-config" ;;
      cunit) includes CUnit/Basic.h || missing="$missing libcunit1-dev" ;;
      gsl) { has pkg-config && pkg-config --exists gsl; } || missing="$missing libgsl-dev" ;;
      petsc) { has pkg-config && pkg-config --exists PETSc; } || missing="$missing petsc-dev" ;;
      gnuplot) has gnuplot || missing="$missing gnuplot-nox" ;;
      c++) has g++ || missing="$missing g++" ;;
      clang) has clang || missing="$missing clang" ;;
      clang-openmp)
        printf '#include <omp.h>\nint main(void) { return omp_get_num_threads() - 1; }\n' |
          clang -fopenmp -x c -o /dev/null - >/dev/null 2>&1 || missing="$missing libomp-dev" ;;
      clang-format) has clang-format || has clang-format-14 || missing="$missing clang-format" ;;
      cmake) has cmake || missing="$missing cmake" ;;
      doxygen) has doxygen || missing="$missing doxygen" ;;
      *) echo "need.sh: unknown need '$need'" >&2; exit 2 ;;
    esac
  done
}

lacking "$@"
[ -z "$missing" ] && exit 0
command="apt-get update && apt-get install -y$missing"
if ! has apt-get; then
  echo "missing:$missing (names of Debian packages; install the like with this system's manager)" >&2
  exit 1
fi
if [ "$(id -u)" -eq 0 ]; then
  as_root=""
elif has sudo && sudo -n true 2>/dev/null; then
  as_root="sudo -n"
else
  echo "missing packages; run as root:  $command" >&2
  exit 1
fi
echo "installing:$missing"
# shellcheck disable=SC2086  # the lists are words on purpose
{ $as_root apt-get update -q && $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y $missing; } || {
  echo "could not install; run as root:  $command" >&2
  exit 1
}
lacking "$@"
[ -z "$missing" ] || { echo "still missing after the installation:$missing" >&2; exit 1; }
