#!/usr/bin/env bash
# Checks the format of changed C++ files, runs clang-tidy, and compiles changed public headers separately:
#   check_changes.sh [BASE]
# BASE: commit to compare with; default: the last commit that is at least one day older than HEAD.
# Only the SURFIT_TIDY_FILES (4) files with the largest changes are checked by clang-tidy, which takes a
# minute per file. `cmake --build --preset tidy` checks all files. Other versions than LLVM 14 have another format and
# other warnings, so they check nothing.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
most=${SURFIT_TIDY_FILES:-4}
day_before=$(($(git log -1 --format=%ct) - 86400))
base=${1:-$(git rev-list -1 --before="$day_before" HEAD)}
base=${base:-$(git hash-object -t tree /dev/null)}  # no such commit: all files

changed() { git diff --name-only --diff-filter=d "$base" -- "$@"; }
mapfile -t files < <(changed '*.h' '*.cc')
if ((${#files[@]} == 0)); then
  echo "No C++ file has changed since $base"
  exit 0
fi
llvm=$(clang-format --version | sed 's/.*version \([0-9]*\).*/\1/')
if ((llvm == 14)); then
  echo "clang-format: ${#files[@]} files"
  clang-format --dry-run -Werror "${files[@]}"
else
  echo "clang-format and clang-tidy: ${#files[@]} changed files skipped; version is $llvm, must be 14"
fi

mapfile -t headers < <(changed 'include/*.h')
if ((${#headers[@]} > 0)); then
  echo "compiled separately: ${#headers[@]} headers"
  printf '#include "%s"\0' "${headers[@]#include/}" |
    xargs --null --max-args=1 --max-procs="$(nproc)" sh -c \
      'echo "$0" | c++ -std=c++17 -fsyntax-only -I include $(pkg-config --cflags eigen3) -x c++ -'
fi
((llvm == 14)) || exit 0

# numstat prints three fields for a renamed file: counts, old name, new name.
mapfile -t sources < <(git diff --numstat -z --diff-filter=d "$base" -- 'src/*.cc' 'tools/*.cc' |
  tr '\0' '\n' | awk '/\t$/ { counts = $0; getline; getline name; print counts name; next } { print }' |
  sort -k1,1nr -k3 | cut -f 3)
looked_at=("${sources[@]:0:most}")
echo "clang-tidy: ${#looked_at[@]} files, $((${#sources[@]} - ${#looked_at[@]})) changed files skipped"
((${#looked_at[@]} > 0)) || exit 0
cmake --preset tidy --log-level=WARNING >/dev/null
printf '%s\n' "${looked_at[@]}" |
  xargs --max-args=1 --max-procs="$(nproc)" clang-tidy -p build/tidy --quiet --extra-arg-before=-std=c++17 2>/dev/null
