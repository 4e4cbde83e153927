#!/usr/bin/env bash
# Tests completion in bash: completion_test.sh FOLDER_OF_PROGRAMS
set -euo pipefail
programs=$1
source "$programs/completion.bash"
compopt() { :; }  # bash defines compopt only during a completion

expect() {  # expect WANTED WORD...: compares the completions of the last word
  local wanted=$1
  shift
  COMP_WORDS=(surfit_slam "$@")
  COMP_CWORD=$#
  COMPREPLY=()
  _surfit "$programs/surfit_slam"
  [[ "${COMPREPLY[*]}" == "$wanted" ]] || { echo "$*: '${COMPREPLY[*]}', not '$wanted'"; exit 1; }
}

folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
touch "$folder/one file"
expect "--output=" --outp
expect "--max_map_points=" --sequence = x --max_ma
expect "$folder/one file" --sequence = "$folder/on"
expect "" --zzzzzz
expect "closed_form_ldlt closed_form_lu closed_form_qr" --solver = closed_form
expect "point_to_point point_to_plane" --residual = point
expect "icl_nuim" --camera = icl
expect "$folder/one file" --camera = "$folder/on"  # a preset or a file
expect "--localize" --locali
expect "--nolocalize" --nolocali
expect "map" --help = ma
[[ $(complete -p surfit_evaluate) == "complete -F _surfit surfit_evaluate" ]]
