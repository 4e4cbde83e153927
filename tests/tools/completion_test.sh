#!/usr/bin/env bash
# Completes as bash would: completion_test.sh FOLDER_OF_PROGRAMS
set -euo pipefail
programs=$1
source "$programs/completion.bash"
compopt() { :; }  # bash has it only within a real completion

expect() {  # expect WANTED WORD...: what completing the last word gives
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
expect "--max_rmse_m=" --sequence = x --max_rm
expect "$folder/one file" --sequence = "$folder/on"
expect "" --no_such_flag
[[ $(complete -p surfit_evaluate) == "complete -F _surfit surfit_evaluate" ]]
