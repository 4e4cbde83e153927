# Fails if a pattern for a label matches no test, for example after a test was renamed.
#   cmake -D PROGRAM=test_room -D PATTERNS=Suite.Name:Suite.* -P patterns_rule.cmake
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND "${PROGRAM}" --gtest_list_tests OUTPUT_VARIABLE listed
  COMMAND_ERROR_IS_FATAL ANY)

# The line of a suite ends with a dot. Tests are indented. "# GetParam() = ..." can follow.
set(tests)
string(REGEX REPLACE "[][;]" "_" listed "${listed}")
string(REPLACE "\n" ";" lines "${listed}")
foreach(line IN LISTS lines)
  string(REGEX REPLACE " *#.*" "" line "${line}")
  if(line MATCHES "^  (.+)$")
    list(APPEND tests "${suite}${CMAKE_MATCH_1}")
  elseif(line MATCHES "^[^ ]+\\.$")
    set(suite "${line}")
  endif()
endforeach()

string(REPLACE ":" ";" patterns "${PATTERNS}")
foreach(pattern IN LISTS patterns)
  string(REPLACE "." "\\." regex "${pattern}")
  string(REPLACE "*" ".*" regex "${regex}")
  string(REPLACE "?" "." regex "${regex}")
  set(matches ${tests})
  list(FILTER matches INCLUDE REGEX "^${regex}$")
  if(NOT matches)
    message(SEND_ERROR "${PROGRAM} has no test '${pattern}'")
  endif()
endforeach()
