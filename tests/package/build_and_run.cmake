# Installs SURFIT_BUILD to a new prefix in WORK, builds and runs the consumer project with this prefix,
# and runs every installed program with --help.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(prefix "${WORK}/prefix")
file(REMOVE_RECURSE "${WORK}")
run("${CMAKE_COMMAND}" --install "${SURFIT_BUILD}" --prefix "${prefix}")

# An installed package must not refer to the source or build tree. Their paths can be parts of the installed
# ones, for example /surfit.
file(GLOB_RECURSE cmake_files "${prefix}/*.cmake")
foreach(file ${cmake_files})
  file(STRINGS "${file}" lines)
  foreach(tree "${SURFIT_SOURCE}" "${SURFIT_BUILD}")
    string(REGEX REPLACE "([][+.*()^$?{}|\\\\])" "\\\\\\1" pattern "${tree}")
    if(lines MATCHES "(^|[\"; =:IL])${pattern}(/|[\"; ]|$)")
      message(FATAL_ERROR "${file} names ${tree}")
    endif()
  endforeach()
endforeach()

run("${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK}/build" -G "${GENERATOR}"
  "-DCMAKE_PREFIX_PATH=${prefix}" -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_COMPILER=${COMPILER}"
  "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}")
run("${CMAKE_COMMAND}" --build "${WORK}/build")
run("${WORK}/build/consumer")
run("${WORK}/build/own_residual")
run("${WORK}/build/registration")

# surfit::registration must not link libraries for image files or plots.
execute_process(COMMAND ldd "${WORK}/build/registration"
  OUTPUT_VARIABLE libraries COMMAND_ERROR_IS_FATAL ANY)
if(libraries MATCHES "turbojpeg|libpng|libtiff|imgcodecs")
  message(FATAL_ERROR "surfit::registration brings ${CMAKE_MATCH_0}:\n${libraries}")
endif()

# pkg-config must list all dependencies of static libraries.
find_program(PKG_CONFIG pkg-config REQUIRED)
file(GLOB archives "${prefix}/lib/libsurfit_*.a")
set(ENV{PKG_CONFIG_PATH} "${prefix}/lib/pkgconfig")
execute_process(COMMAND "${PKG_CONFIG}" --static --cflags --libs surfit
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags)
run("${COMPILER}" -std=c++17 "${CMAKE_CURRENT_LIST_DIR}/main.cc" -o "${WORK}/by_pkg_config"
  -Wl,--whole-archive ${archives} -Wl,--no-whole-archive ${flags} "-Wl,-rpath,${prefix}/lib")
run("${WORK}/by_pkg_config")

# Builds a SLAM program with only these flags.
run("${COMPILER}" -std=c++17 "${SURFIT_SOURCE}/docs/examples/use_slam.cc" -o "${WORK}/use_slam"
  ${flags} "-Wl,-rpath,${prefix}/lib")
run("${prefix}/bin/surfit_simulate" "--output=${WORK}/room" --frames=3 --downsample=8)
run("${WORK}/use_slam" "${WORK}/room" "${WORK}")
execute_process(COMMAND ldd "${WORK}/use_slam" OUTPUT_VARIABLE libraries COMMAND_ERROR_IS_FATAL ANY)
if(archives AND libraries MATCHES "libsurfit")
  message(FATAL_ERROR "pkg-config --static lists shared libraries of Surfit:\n${libraries}")
endif()

file(GLOB programs "${prefix}/bin/*")
foreach(program ${programs})
  file(READ "${program}" head LIMIT 2)
  if(head MATCHES "^#!")
    continue()  # name of a removed program
  endif()
  execute_process(COMMAND "${program}" --help OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
