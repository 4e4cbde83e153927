# Doxygen filter for plain comments. A comment on its own lines documents the next declaration. A
# comment after code, with aligned lines below it, documents the declaration before it.
function Escaped(text) {
  gsub(/[\\@<>#&"]/, "\\\\&", text)
  return text
}
match($0, /^ *\/\/( |$)/) {
  column = index($0, "//")
  marker = column == trailing_column ? "///< " : "/// "
  print substr($0, 1, column - 1) marker Escaped(substr($0, column + 3))
  next
}
match($0, /[;,{}>] +\/\/ /) {
  trailing_column = index(substr($0, RSTART), "//") + RSTART - 1
  print substr($0, 1, trailing_column - 1) "///< " Escaped(substr($0, trailing_column + 3))
  next
}
{
  trailing_column = 0
  print
}
