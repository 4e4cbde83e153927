# Plants one file at a time in an otherwise empty tree under WORK and looks at what the include
# rule says of it.
cmake_minimum_required(VERSION 3.25)

# Sets <output> to the rule's output for a tree with this one file, <result> to its exit code.
function(run_rule file include)
  file(REMOVE_RECURSE "${WORK}")
  file(WRITE "${WORK}/${file}" "#pragma once\n#include ${include}\n")
  execute_process(
    COMMAND "${CMAKE_COMMAND}" -D "ROOT=${WORK}" -P "${ROOT}/tests/structure/include_rule.cmake"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  set(result "${result}" PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect_allowed file include)
  run_rule("${file}" "${include}")
  if(NOT result EQUAL 0)
    message(SEND_ERROR "${file} with ${include} was refused: ${output}")
  endif()
endfunction()

function(expect_refused file include reason)
  run_rule("${file}" "${include}")
  string(FIND "${output}" "${file}: includes ${include}, but ${reason}" position)
  if(result EQUAL 0 OR position EQUAL -1)
    message(SEND_ERROR "${file} with ${include} was not refused with '${reason}': ${output}")
  endif()
endfunction()

expect_allowed(include/surfit/slam/a.h "\"surfit/core/error.h\"")
expect_allowed(include/surfit/mapping/a.h "<Eigen/Core>")
expect_allowed(include/surfit/core/a.h "<vector>")
expect_allowed(src/registration/a.cc "<ceres/manifold.h>")
expect_allowed(src/registration/a.cc "\"cost_functions/a.h\"")
expect_allowed(src/io/a.cc "\"io/b.h\"")
expect_allowed(src/io/a.cc "<opencv2/imgcodecs.hpp>")

expect_refused(include/surfit/core/a.h "\"surfit/geometry/rigid3.h\"" "core may include only core")
expect_refused(src/registration/a.cc "\"surfit/mapping/surfel_map.h\"" "registration may include only")
expect_refused(src/mapping/a.h "\"registration/icp.h\"" "mapping may include only")
expect_refused(src/evaluation/a.cc "\"surfit/io/tum.h\"" "evaluation may include only evaluation")
expect_refused(src/io/a.cc "\"testing/scene.h\"" "'testing' is none of our rooms")
expect_refused(include/surfit/io/a.h "\"io/b.h\"" "a public header includes public headers only")
foreach(header ceres/ceres.h glog/logging.h gflags/gflags.h opencv2/core.hpp tbb/parallel_for.h)
  expect_refused(include/surfit/frame/a.h "<${header}>" "a public header carries only")
endforeach()
expect_refused(src/mapping/a.cc "<ceres/ceres.h>" "Ceres belongs to registration")
expect_refused(src/io/a.cc "<gflags/gflags.h>" "flags belong to the programs")

# A tree without files must not pass for a good one.
file(REMOVE_RECURSE "${WORK}")
execute_process(
  COMMAND "${CMAKE_COMMAND}" -D "ROOT=${WORK}" -P "${ROOT}/tests/structure/include_rule.cmake"
  RESULT_VARIABLE result ERROR_QUIET)
if(result EQUAL 0)
  message(SEND_ERROR "the include rule passed a tree without files")
endif()
