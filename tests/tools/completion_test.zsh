#!/usr/bin/env zsh
# Tests completion in a zsh on a pseudo terminal: completion_test.zsh FOLDER_OF_PROGRAMS
programs=$1
zmodload zsh/zpty || exit 77
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cp "$programs/completion.zsh" "$folder/_surfit"
touch "$folder/one_file"

# Prints the command line after a tab: the shell inserts the completion and shows the line.
completed() {
  local line
  zpty shell "zsh -f -i"
  zpty -w shell "PS1= TERM=dumb; fpath=($folder \$fpath); autoload -U compinit; compinit -u -D"
  zpty -w shell "report() { print -r -- \"<\$BUFFER>\" }; zle -N report; bindkey '^X' report"
  zpty -w -n shell "$programs/surfit_slam $1"$'\t\C-X'
  zpty -r shell line "*<$programs/*>*"
  zpty -d shell
  print -r -- ${${line##*<$programs/surfit_slam }%%>*}
}
expect() {  # expect WANTED WORD
  local is=$(completed $2)
  [[ $is == $1 ]] || { print "$2: '$is', not '$1'"; exit 1 }
}

expect '--output=' --outp
expect '--camera=icl_nuim ' --camera=icl
expect '--solver=tiny ' --solver=ti
expect "--sequence=$folder/one_file " --sequence=$folder/on
expect '--nopictures ' --nopic
