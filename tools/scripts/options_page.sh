#!/usr/bin/env bash
# Prints docs/options.md: each flag once, with its programs, from --help=all of all programs.
#   options_page.sh PROGRAMS_FOLDER > docs/options.md
#   options_page.sh PROGRAMS_FOLDER --compare=docs/options.md    exits with 1 if the page is outdated
#   options_page.sh PROGRAMS_FOLDER --count    prints the numbers of flags, exits with 1 if there are too many
# Exits with 1 if two programs have different texts for one flag, except flags with other choices.
set -euo pipefail
programs=$1
page=${2-}

print_help() {
  local program
  for program in slam session refine report align register compare_solvers doctor evaluate record \
    convert mesh optimize batch scan simulate; do
    echo "@ $program"
    "$programs/surfit_$program" --help=all
  done
}

print_page() {
  cat <<'END'
# Options

All flags of all programs. Each entry has the default value, the description, and in brackets the programs, without
`surfit_`. `batch=1`: the default in `surfit_batch` is 1. `evaluate (map, views)` and `scan (link, tile)` list the
values of `--what` and `--step` with this flag.

`--help` prints the everyday flags of a program, `--help=GROUP` the flags of a group, `--help=all` all flags.
`--flagfile=F` reads flags from a file, one per line; `#` starts a comment.
In C++ and Python, the options have more fields than there are flags: see the headers of the structs.

`tools/scripts/options_page.sh build/release/tools > docs/options.md` creates this page. A test compares the page with
the help of the programs.
END
  print_help | awk '
    # Wraps words to 84 columns, with an indent.
    function wrapped(text, indent,    words, column, count, i, lines) {
      count = split(text, words, " ")
      column = indent
      for (i = 1; i <= count; ++i) {
        if (column > indent && column + 1 + length(words[i]) > 84) {
          lines = lines sprintf("\n%*s", indent, "")
          column = indent
        }
        lines = lines (column > indent ? " " : "") words[i]
        column += length(words[i]) + (column > indent ? 1 : 0)
      }
      return lines
    }
    # Help of a flag, and one line per setting of its value.
    function help_lines(text,    parts, count, i, lines) {
      count = split(text, parts, "\n")
      lines = wrapped(parts[1], 30)
      for (i = 2; i <= count; ++i) lines = lines sprintf("\n%32s", "") wrapped(parts[i], 34)
      return lines
    }
    function finish(    modes, text, place, flag) {
      if (name == "" || name == "flagfile") return
      modes = ""
      if (match(help, / \[[^]]*\]$/)) {
        modes = " (" substr(help, RSTART + 2, RLENGTH - 3) ")"
        help = substr(help, 1, RSTART - 1)
      }
      # The choices of some flags depend on the program.
      flag = name ~ /^(start|solver|linear_solver|residual|association|threads|format|imu|part)$/ && name in text_of && text_of[name] != help ? name "@" program : name
      if (!(flag in text_of)) {
        names[++flags] = flag
        text_of[flag] = help
        default_of[flag] = value
        group_of[flag] = group
        if (!(group in known)) {
          known[group] = 1
          groups[++group_count] = group
        }
      } else if (text_of[flag] != help) {
        printf "error: --%s is \"%s\" in one program, \"%s\" in surfit_%s\n", name, text_of[flag], help,
          program > "/dev/stderr"
        failed = 1
      }
      place = program modes (default_of[flag] == value ? "" : "=" value)
      programs_of[flag] = programs_of[flag] (programs_of[flag] == "" ? "" : ", ") place
      name = ""
    }
    /^@ / { finish(); program = $2; group = "surfit_" program; next }
    /^Options of / { finish(); group = substr($0, 12, length($0) - 12); next }
    /^[^ ]/ || /^$/ { finish(); next }
    /^  --/ {
      finish()
      name = substr($1, 3, index($1, "=") - 3)
      value = substr($1, index($1, "=") + 1)
      help = $0
      sub(/^  --[^ ]* */, "", help)
      next
    }
    {
      match($0, /[^ ]/)
      is_setting = RSTART == 29
      sub(/^ */, "")
      help = help (help == "" ? "" : is_setting ? "\n" : " ") $0
    }
    END {
      finish()
      for (g = 1; g <= group_count; ++g) {
        printf "\n## %s\n\n", groups[g]
        for (i = 1; i <= flags; ++i) {
          flag = names[i]
          if (group_of[flag] != groups[g]) continue
          head = "    --" flag "=" default_of[flag]
          sub(/@[^=]*/, "", head)
          if (length(head) + 2 > 30) head = head sprintf("\n%30s", "")
          printf "%-30s%s\n", head, help_lines(text_of[flag])
          printf "%30s%s\n", "", wrapped("[" programs_of[flag] "]", 30)
        }
      }
      exit failed
    }'
}

# Counts the different flags of surfit_slam and of all programs.
count_flags() {
  print_help | awk '
    /^@ / { program = $2 }
    /^  --/ {
      name = substr($1, 3, index($1, "=") - 3)
      if (name == "flagfile") next
      if (program == "slam") ++of_slam
      if (!(name in seen)) ++distinct
      seen[name] = 1
    }
    END {
      printf "surfit_slam has %d flags, at most 60. All programs have %d flags, at most 130.\n", of_slam, distinct
      exit of_slam > 60 || distinct > 130
    }'
}

if [[ $page == --count ]]; then
  count_flags
  exit
fi
text=$(print_page)
case $page in
  '') echo "$text" ;;
  --compare=*)
    if ! diff "${page#*=}" <(echo "$text"); then
      echo "${page#*=} is outdated: see the usage at the top of $0" >&2
      exit 1
    fi
    ;;
  *) echo "error: unexpected argument '$page'" >&2; exit 1 ;;
esac
