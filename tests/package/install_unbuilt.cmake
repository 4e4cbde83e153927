# `cmake --install` must succeed if programs, man pages and the Python package are not built. Here no
# target is built.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${WORK}")
run("${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}/build" -G "${GENERATOR}"
  "-DCMAKE_CXX_COMPILER=${COMPILER}" -DCMAKE_BUILD_TYPE=Release -DSURFIT_BUILD_TESTS=OFF)
foreach(component tools python)
  run("${CMAKE_COMMAND}" --install "${WORK}/build" --prefix "${WORK}/prefix" --component ${component})
endforeach()
file(GLOB_RECURSE installed "${WORK}/prefix/bin/*" "${WORK}/prefix/share/man/*"
  "${WORK}/prefix/lib/python3/*")
if(installed)
  message(FATAL_ERROR "installed without a build: ${installed}")
endif()
