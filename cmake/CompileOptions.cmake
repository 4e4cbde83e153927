# Warnings, sanitizers and floating-point rules that every target of ours shares.
# No contraction: a*b+c must round the same way on every machine and at every inlining. Nobody reads
# errno or floating-point traps, and without them more loops become SIMD code.
function(surfit_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -ffp-contract=off
                         -fno-math-errno -fno-trapping-math)
  if(SURFIT_SANITIZE)
    # Of UBSan without the checks at each access, which take 40 % of the compiler's time: the
    # processor and AddressSanitizer tell null, aligned vector loads tell misalignment.
    target_compile_options(${target} PRIVATE -fsanitize=${SURFIT_SANITIZE}
      -fno-sanitize=null,alignment,vptr -fno-sanitize-recover=all -fno-omit-frame-pointer
      $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>  # instrumented code misleads it, within <regex> for one
      $<$<BOOL:${SURFIT_BUILD_FUZZERS}>:-fsanitize=fuzzer-no-link>)
    target_link_options(${target} PUBLIC -fsanitize=${SURFIT_SANITIZE})
    # Eigen would change its allocator under AddressSanitizer and disagree with prebuilt libraries.
    target_compile_definitions(${target} PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
    if(SURFIT_SANITIZE MATCHES "thread")
      # ThreadSanitizer knows no fences. Boost.Asio has locks beside them.
      target_compile_definitions(${target} PRIVATE BOOST_ASIO_DISABLE_FENCED_BLOCK)
    endif()
  endif()
endfunction()

# What nearly every source file includes, and more headers if given, is compiled once for the targets of
# a kind, which compile alike: the first makes the precompiled header, the others use it.
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
