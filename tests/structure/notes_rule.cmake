# third_party_notes.md must list, in code quotes, each package of find_package() and each Debian package
# of the installation script.
cmake_minimum_required(VERSION 3.25)
file(READ "${ROOT}/third_party_notes.md" notes)

function(expect_in_notes name where)
  string(FIND "${notes}" "`${name}`" position)
  if(position EQUAL -1)
    message(SEND_ERROR "${where} names ${name}, which third_party_notes.md does not")
  endif()
endfunction()

set(count 0)
file(GLOB_RECURSE cmake_files RELATIVE "${ROOT}" "${ROOT}/src/CMakeLists.txt"
  "${ROOT}/tools/CMakeLists.txt" "${ROOT}/tests/CMakeLists.txt" "${ROOT}/python/CMakeLists.txt"
  "${ROOT}/cmake/*.cmake" "${ROOT}/cmake/*.cmake.in")
list(REMOVE_ITEM cmake_files tests/package/CMakeLists.txt)
foreach(file CMakeLists.txt ${cmake_files})
  file(STRINGS "${ROOT}/${file}" lines REGEX "^ *find_(package|dependency) *\\(")
  foreach(line ${lines})
    string(REGEX MATCH "\\(([A-Za-z0-9_]+)" ignored "${line}")
    expect_in_notes("${CMAKE_MATCH_1}" "${file}")
    math(EXPR count "${count} + 1")
  endforeach()
endforeach()

set(script tools/scripts/install_dependencies.sh)
file(READ "${ROOT}/${script}" text)
string(REGEX MATCHALL "packages=\\([^)]*\\)" lists "${text}")
string(REGEX REPLACE "#[^\n]*|[a-z_]*packages=\\(|\\)" "" packages "${lists}")
string(REGEX MATCHALL "[^ \n;]+" packages "${packages}")
foreach(package ${packages})
  expect_in_notes("${package}" "${script}")
endforeach()

if(count EQUAL 0 OR NOT packages)
  message(SEND_ERROR "found ${count} CMake packages and the Debian packages '${packages}'")
endif()
