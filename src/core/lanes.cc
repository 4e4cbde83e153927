#include "surfit/core/lanes.h"

#include <cstdlib>
#include <string_view>

namespace surfit {

bool UsesAvx2() {
#if SURFIT_HAS_AVX2
  static const bool uses_avx2 = [] {
    const char* const wanted = std::getenv("SURFIT_INSTRUCTIONS");
    const bool base_wanted = wanted != nullptr && std::string_view(wanted) == "base";
    return !base_wanted && __builtin_cpu_supports("avx2");
  }();
  return uses_avx2;
#else
  return false;
#endif
}

}  // namespace surfit
