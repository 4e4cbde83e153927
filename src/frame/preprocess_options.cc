#include "surfit/core/error.h"
#include "surfit/frame/preprocess.h"

namespace surfit {

void PreprocessOptions::Validate() const {
  const auto require = [](bool holds, const char* field, double value, const char* constraint) {
    if (!holds) throw InputError(Concat(field, " is ", value, ", must be ", constraint));
  };
  require(noise.inverse_depth_sigma > 0 && noise.inverse_depth_sigma < 1, "inverse_depth_sigma",
          noise.inverse_depth_sigma, "positive and below 1 (1/m)");
  require(filter_radius_px >= 0 && filter_radius_px <= 7, "filter_radius_px", filter_radius_px,
          "from 0 to 7");
  require(filter_cutoff > 0 && filter_cutoff < 1e3, "filter_cutoff", filter_cutoff,
          "positive and below 1000");
  require(normal_radius_px >= 1 && normal_radius_px <= 7, "normal_radius_px", normal_radius_px,
          "from 1 to 7");
  require(max_slant_rad > 0 && max_slant_rad < 1.57, "max_slant_rad", max_slant_rad,
          "positive and below 1.57");
  require(pyramid_levels >= 1 && pyramid_levels <= 8, "pyramid_levels", pyramid_levels,
          "from 1 to 8");
}

}  // namespace surfit
