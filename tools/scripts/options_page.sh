#!/usr/bin/env bash
# Prints docs/options.md: every flag of every program, as its --help=all has it.
#   options_page.sh PROGRAMS_FOLDER > docs/options.md
#   options_page.sh PROGRAMS_FOLDER --compare=docs/options.md    exits with 1 if that is out of date
set -euo pipefail
programs=$1
page=${2-}

print_page() {
  cat <<'END'
# Options

All flags of all programs: each with its default, group by group. `--help` of a program shows the
everyday ones, `--help=GROUP` those of a group, `--help=all` all. `--flagfile=F` reads flags from
a file, one a line; `#` begins a comment.
In C++ and Python options have more fields than there are flags: see the structs' headers.

`tools/scripts/options_page.sh build/release/tools > docs/options.md` makes this page; a test holds
it to what the programs say.
END
  local program
  for program in slam session refine report align register compare_solvers doctor evaluate evaluate_map \
    evaluate_revisits evaluate_views find_loops record convert mesh optimize batch scan plan scan_candidates scan_link scan_graph scan_tile \
    scan_report simulate; do
    printf '\n## surfit_%s\n\n' "$program"
    "$programs/surfit_$program" --help=all |
      sed -n '/^Options from/,$d; s/^Options of \(.*\):$/### \1\n/p; /^ /s/^/  /p; /^$/p' |
      sed '1{/^$/d}' | cat -s
  done
}

case $page in
  '') print_page ;;
  --compare=*)
    if ! diff "${page#*=}" <(print_page); then
      echo "${page#*=} is out of date: see the head of $0" >&2
      exit 1
    fi
    ;;
  *) echo "error: unexpected argument '$page'" >&2; exit 1 ;;
esac
