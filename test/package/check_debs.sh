#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# check_debs.sh FOLDER: unpacks the packages of FOLDER into a root of their own and works from there as their users do: the
# demo's main command, man page and completion, a C++ program by CMake and by pkg-config, a line of Python; then removes
# them, and looks for what is left.
set -euo pipefail
debs=$(realpath "$1")
here=$(dirname "$(realpath "${BASH_SOURCE[0]}")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/root
admin=$root/var/lib/dpkg
mkdir -p "$admin/info" "$admin/updates"
: > "$admin/status"
say() { printf '== %s\n' "$*"; }
# The dependencies are those of the machine; only these packages are in the root. They are not configured, because their
# scripts, which compile Python, need a whole system around them.
in_root() { dpkg --root="$root" --force-not-root --force-depends --log="$work/log" "$@" > "$work/dpkg" 2>&1 ||
  { cat "$work/dpkg"; exit 1; }; }

mapfile -t packages < <(ls "$debs"/*.deb)
say "installing ${packages[*]##*/}"
in_root --unpack "${packages[@]}"
export PATH=$root/usr/bin:$PATH PYTHONDONTWRITEBYTECODE=1
libdir=$(dirname "$(dirname "$(find "$root/usr/lib" -name xview.pc)")")

say "every library is there"
for binary in "$root/usr/bin/xview" "$libdir"/xview/xview_{codecs,network}.so \
  "$root"/usr/lib/python3/dist-packages/xview/_xview*.so; do
  if ldd "$binary" | grep 'not found'; then exit 1; fi
done

say "the program: $(xview --version)"
cd "$work"
xview simulate town --seed 7 --route_length_m 100 --sessions.aerial=false --quiet > /dev/null
xview map town/forward town.xvm --quiet > /dev/null
xview localize town/rear town.xvm --quiet | tee answer.txt
grep -q accepted answer.txt
[[ $(man --warnings -l "$root/usr/share/man/man1/xview-localize.1.gz" 2>&1 | grep -c -- --window) -gt 0 ]]
bash -c 'source "$1"; COMP_WORDS=(xview localize --metho) COMP_CWORD=2; _xview; [[ ${COMPREPLY[*]} == --method ]]' _ \
  "$root/usr/share/bash-completion/completions/xview"

say "a C++ program by CMake and by pkg-config"
cmake -S "$here/consumer" -B consumer -DCMAKE_PREFIX_PATH="$root/usr" > cmake.log || { cat cmake.log; exit 1; }
cmake --build consumer > cmake.log || { cat cmake.log; exit 1; }
sed "s|^prefix=.*|prefix=$root/usr|" "$libdir/pkgconfig/xview.pc" > xview.pc  # as if the root were /
read -ra flags <<< "$(PKG_CONFIG_PATH=. pkg-config --cflags --libs xview)"
g++ -O0 "$here"/consumer/*.cpp -o by_pkg_config "${flags[@]}"
for program in consumer/consumer ./by_pkg_config; do
  code=0
  "$program" > /dev/null 2>&1 || code=$?
  ((code == 2)) || { echo "$program without arguments ended with $code, expected 2"; exit 1; }
done

say "a line of Python"
PYTHONPATH=$root/usr/lib/python3/dist-packages /usr/bin/python3 -c '
import xview
fix = xview.Localizer(xview.load_map("town.xvm")).localize(xview.read("town/rear"))
assert fix.accepted, fix.reason
print(xview.__version__, fix.status, fix.T_map_sensor[:3, 3])'

say "removing them"
in_root --purge xview libxview-dev python3-xview
left=$(find "$root" -path "$root/var" -prune -o -type f -print)
[[ -z $left ]] || { printf 'left: %s\n' "$left"; exit 1; }
say "nothing is left"
