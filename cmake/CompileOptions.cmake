# Warnings, sanitizers and floating-point options of all targets.
# - No contraction: a*b+c is rounded equally on all machines.
# - No errno and no floating-point traps: more loops can be vectorised.
function(surfit_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -ffp-contract=off
                         -fno-math-errno -fno-trapping-math)
  if(SURFIT_SANITIZE)
    # Without UBSan's checks of each memory access, which take 40 % of the compile time. Null
    # pointers fault anyway, and AddressSanitizer and aligned vector loads detect misalignment.
    target_compile_options(${target} PRIVATE -fsanitize=${SURFIT_SANITIZE}
      -fno-sanitize=null,alignment,vptr -fno-sanitize-recover=all -fno-omit-frame-pointer
      $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>  # false positives in instrumented code, for example in <regex>
      $<$<BOOL:${SURFIT_BUILD_FUZZERS}>:-fsanitize=fuzzer-no-link>)
    target_link_options(${target} PUBLIC -fsanitize=${SURFIT_SANITIZE})
    # Eigen's allocator under AddressSanitizer is incompatible with prebuilt libraries.
    target_compile_definitions(${target} PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
    if(SURFIT_SANITIZE MATCHES "thread")
      # ThreadSanitizer does not support fences. Boost.Asio also uses locks.
      target_compile_definitions(${target} PRIVATE BOOST_ASIO_DISABLE_FENCED_BLOCK)
    endif()
  endif()
endfunction()

# Precompiles common headers, and the headers of the further arguments. Targets of one kind have the
# same compile options: the first target creates the precompiled header, the others reuse it.
function(surfit_precompile target kind)
  get_property(owner GLOBAL PROPERTY surfit_precompiled_${kind})
  if(owner)
    target_precompile_headers(${target} REUSE_FROM ${owner})
    return()
  endif()
  set_property(GLOBAL PROPERTY surfit_precompiled_${kind} ${target})
  target_precompile_headers(${target} PRIVATE <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cmath>
    <cstdint> <cstring> <fstream> <functional> <limits> <map> <memory> <optional> <sstream> <string>
    <utility> <vector> ${ARGN})
endfunction()
