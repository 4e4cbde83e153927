#!/usr/bin/env bash
# Holds the C++ files that changed to clang-format and clang-tidy, and compiles public headers alone:
#   check_changes.sh [BASE]
# BASE is the commit that they are compared with, by default the last one at least a day older than
# HEAD. clang-tidy takes a minute a file: of more than SURFIT_TIDY_FILES (4) changed ones it looks at
# those that changed most, and says how many it left out. `cmake --build --preset tidy` looks at all.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
most=${SURFIT_TIDY_FILES:-4}
day_before=$(($(git log -1 --format=%ct) - 86400))
base=${1:-$(git rev-list -1 --before="$day_before" HEAD)}
base=${base:-$(git hash-object -t tree /dev/null)}  # a history of less than a day: all files

changed() { git diff --name-only --diff-filter=d "$base" -- "$@"; }
mapfile -t files < <(changed '*.h' '*.cc')
if ((${#files[@]} == 0)); then
  echo "No C++ file has changed since $base"
  exit 0
fi
echo "clang-format: ${#files[@]} files"
clang-format --dry-run -Werror "${files[@]}"

mapfile -t headers < <(changed 'include/*.h')
if ((${#headers[@]} > 0)); then
  echo "compiled alone: ${#headers[@]} headers"
  printf '#include "%s"\0' "${headers[@]#include/}" |
    xargs --null --max-args=1 --max-procs="$(nproc)" sh -c \
      'echo "$0" | c++ -std=c++17 -fsyntax-only -I include $(pkg-config --cflags eigen3) -x c++ -'
fi

# A renamed file is three fields of numstat: the counts, the old name, the new name.
mapfile -t sources < <(git diff --numstat -z --diff-filter=d "$base" -- 'src/*.cc' 'tools/*.cc' |
  tr '\0' '\n' | awk '/\t$/ { counts = $0; getline; getline name; print counts name; next } { print }' |
  sort -k1,1nr -k3 | cut -f 3)
looked_at=("${sources[@]:0:most}")
echo "clang-tidy: ${#looked_at[@]} files, $((${#sources[@]} - ${#looked_at[@]})) changed ones left out"
((${#looked_at[@]} > 0)) || exit 0
cmake --preset tidy --log-level=WARNING >/dev/null
printf '%s\n' "${looked_at[@]}" |
  xargs --max-args=1 --max-procs="$(nproc)" clang-tidy -p build/tidy --quiet --extra-arg-before=-std=c++17 2>/dev/null
