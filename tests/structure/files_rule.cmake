# Rules:
# - Each .cc file is listed in the CMakeLists.txt of its folder, or of the nearest parent folder with
#   one, or as ../folder/file.cc in another CMakeLists.txt.
# - Each public header is in the list of its module.
# - Each other header is included by a file.
cmake_minimum_required(VERSION 3.25)

file(GLOB_RECURSE sources RELATIVE "${ROOT}" "${ROOT}/src/*.cc" "${ROOT}/tools/*.cc"
  "${ROOT}/tests/*.cc" "${ROOT}/python/*.cc")
file(GLOB_RECURSE public_headers RELATIVE "${ROOT}" "${ROOT}/include/*.h")
file(GLOB_RECURSE internal_headers RELATIVE "${ROOT}" "${ROOT}/src/*.h" "${ROOT}/tools/*.h"
  "${ROOT}/tests/*.h" "${ROOT}/python/*.h" "${ROOT}/cost_functions/*.h")
if(NOT sources OR NOT public_headers)
  message(SEND_ERROR "no files under ${ROOT}")
endif()

# The folder of the file, or its nearest parent folder with a CMakeLists.txt.
function(listing_folder file result)
  cmake_path(GET file PARENT_PATH folder)
  while(NOT EXISTS "${ROOT}/${folder}/CMakeLists.txt")
    cmake_path(GET folder PARENT_PATH folder)
  endwhile()
  set(${result} "${folder}" PARENT_SCOPE)
endfunction()

set(all_lists)
file(GLOB_RECURSE list_files "${ROOT}/src/CMakeLists.txt" "${ROOT}/tools/CMakeLists.txt"
  "${ROOT}/tests/CMakeLists.txt" "${ROOT}/python/CMakeLists.txt")
foreach(file ${list_files})
  file(READ "${file}" list)
  string(APPEND all_lists "${list}")
endforeach()

# Programs may be listed without their file extension.
foreach(file ${sources})
  listing_folder("${file}" folder)
  file(READ "${ROOT}/${folder}/CMakeLists.txt" list)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${folder}" OUTPUT_VARIABLE name)
  string(REGEX REPLACE "\\.cc$" "" stem "${name}")
  string(REGEX MATCH "[^/]+/[^/]+$" with_folder "${file}")
  if(NOT list MATCHES "[ \n(/]${stem}(\\.cc)?[ \n)]" AND NOT all_lists MATCHES "\\.\\./${with_folder}")
    message(SEND_ERROR "${file} is not listed in ${folder}/CMakeLists.txt")
  endif()
endforeach()

foreach(file ${public_headers})
  string(REGEX MATCH "^include/surfit/([^/]+)/" ignored "${file}")
  set(listing "src/${CMAKE_MATCH_1}/CMakeLists.txt")
  file(READ "${ROOT}/${listing}" list)
  cmake_path(GET file FILENAME name)
  if(NOT list MATCHES "[ \n]${name}[ \n]")
    message(SEND_ERROR "${file} is not listed in ${listing}")
  endif()
endforeach()

set(includes)
foreach(file ${sources} ${public_headers} ${internal_headers})
  file(STRINGS "${ROOT}/${file}" lines REGEX "^#include \"")
  list(APPEND includes ${lines})
endforeach()
foreach(file ${internal_headers})
  set(name "${file}")
  if(file MATCHES "^(src|tools|tests|python)/(.+)$")  # REPLACE would also match "tests/tools/"
    set(name "${CMAKE_MATCH_2}")
  endif()
  if(NOT "#include \"${name}\"" IN_LIST includes)
    message(SEND_ERROR "no file includes ${file} (as \"${name}\")")
  endif()
endforeach()
