#!/usr/bin/env bash
# Creates the manual page of a program from --help=all: man_page.sh PROGRAM VERSION OUTPUT.gz
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
help=$("$1" --help)
# The first sentence, without the name of the program.
summary=$(head -n 1 <<<"$help" | sed 's/^[^:]*: //; s/\. .*//; s/\.$//')
help2man --no-info --help-option=--helpfull --version-string="$2" --name="$summary" --include="$here/exit_codes.h2m" "$1" |
  gzip -9n >"$3"
