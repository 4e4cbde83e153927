#!/bin/bash
# Runs under the names of programs of version 0.1. Prints the command line of version 0.2 and runs it.
# Version 0.3 drops these names.
arguments=()
name=$(basename "$0")
renamed=''
case $name in
  surfit_evaluate_map) command='surfit_evaluate --what=map' ;;
  surfit_evaluate_views)
    command='surfit_evaluate --what=views'
    renamed='s/^--?pictures=0$/--nopictures/; s/^--?pictures=[0-9]+$/--pictures/'
    ;;
  surfit_evaluate_revisits)
    command='surfit_evaluate --what=revisits'
    renamed='s/^(--?)min_gap\b/\1revisit_gap/'
    ;;
  surfit_plan) command='surfit_scan --step=plan' ;;
  surfit_scan_*)
    command="surfit_scan --step=${name#surfit_scan_}" renamed='s/^(--?)(candidates|tile)\b/\1part/'
    ;;
  surfit_find_loops)
    echo "error: $name was removed in 0.2: surfit_slam --loop_closure writes loops.csv" >&2
    exit 1
    ;;
esac
for argument in "$@"; do
  arguments+=("$(sed -E "$renamed" <<<"$argument")")
done
words=($command "${arguments[@]}")
echo "warning: $name was renamed in 0.2: use$(printf ' %q' "${words[@]}")" >&2
exec "$(dirname "$0")/${words[0]}" "${words[@]:1}"
