#!/bin/sh
# Installs below a scratch DESTDIR, then builds and runs a program that knows only pkg-config, and
# one that knows only CMake's find_package; at last uninstalls and looks for what was left.
#
#   check-installed.sh FOLDER
set -eu
: "${MAKE:=make}" "${CC:=gcc}" "${PKG_CONFIG:=pkg-config}"
mkdir -p "$1"
folder=$(cd "$1" && pwd)
rm -rf "$folder"
mkdir -p "$folder/program"
root=$folder/root
prefix=/opt/sph
$MAKE --no-print-directory -s install BUILD="$BUILD" DESTDIR="$root" prefix=$prefix

cat >"$folder/program/main.c" <<'END'
#include <sph.h>
#include <stdio.h>

int main(void) {
  sph_context *context = NULL;
  if (sph_context_create(&context) != SPH_OK) return 1;
  sph_context_destroy(&context);
  puts(sph_version());
  return 0;
}
END
expect() {
  found=$("$2")
  [ "$found" = "$VERSION" ] || { echo "$1: the program says '$found', not '$VERSION'" >&2; exit 1; }
  echo "$1: ok"
}

PKG_CONFIG_LIBDIR=$root$prefix/lib/pkgconfig:$($PKG_CONFIG --variable pc_path pkg-config)
export PKG_CONFIG_LIBDIR
flags="--define-variable=prefix=$root$prefix sph"
[ "$($PKG_CONFIG --modversion sph)" = "$VERSION" ]
# shellcheck disable=SC2046,SC2086  # lists of words
$CC -o "$folder/program/shared" "$folder/program/main.c" $($PKG_CONFIG --cflags --libs $flags) \
  -Wl,-rpath,"$root$prefix/lib"
expect "pkg-config, shared" "$folder/program/shared"
# shellcheck disable=SC2046,SC2086
$CC -o "$folder/program/static" "$folder/program/main.c" $($PKG_CONFIG --cflags $flags) \
  "$root$prefix/lib/libsph.a" $($PKG_CONFIG --static --libs $flags | sed 's/-lsph//')
expect "pkg-config, static" "$folder/program/static"

if command -v cmake >/dev/null 2>&1; then
  cat >"$folder/program/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.10)
project(program C)
find_package(sph VERSION_HERE REQUIRED)
add_executable(cmake_shared main.c)
target_link_libraries(cmake_shared sph::sph)
add_executable(cmake_static main.c)
target_link_libraries(cmake_static sph::sph_static)
END
  sed -i "s/VERSION_HERE/${VERSION%.*}/" "$folder/program/CMakeLists.txt"
  if ! { CC=$CC cmake -S "$folder/program" -B "$folder/cmake" -DCMAKE_PREFIX_PATH="$root$prefix" &&
    cmake --build "$folder/cmake"; } >"$folder/cmake.log" 2>&1; then
    cat "$folder/cmake.log" >&2
    exit 1
  fi
  expect "CMake, shared" "$folder/cmake/cmake_shared"
  expect "CMake, static" "$folder/cmake/cmake_static"
else
  echo "CMake: not installed, not checked"
fi

$MAKE --no-print-directory -s uninstall BUILD="$BUILD" DESTDIR="$root" prefix=$prefix
left=$(find "$root" ! -type d)
[ -z "$left" ] || { echo "uninstall left: $left" >&2; exit 1; }
echo "uninstall: ok"
