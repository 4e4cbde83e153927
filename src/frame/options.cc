#include "surfit/core/options.h"

#include "core/shared_options.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rectify_frame.h"

namespace surfit {

void PreprocessOptions::Visit(OptionVisitor& v) {
  v.Group("surfaces");
  v.Add(filter_radius_px, "filter_radius_px", "half width of the depth filter window",
        Between(0, 7), ZeroIs("no filter"), InUnit("px"));
  v.Add(filter_cutoff, "filter_cutoff",
        "maximum difference of inverse depths in the depth filter, in sigmas", Positive(),
        Below(1000));
  v.Add(normal_radius_px, "normal_radius_px",
        "maximum pixel offset of the depths that a normal is computed from", Between(1, 7),
        InUnit("px"));
  v.Add(max_slant_rad, "max_slant_rad",
        "larger angles between surface normal and viewing ray are depth edges", Positive(),
        Below(1.57));
  v.Add(pyramid_levels, "pyramid_levels",
        "maximum number of pyramid levels for registration; small images have fewer",
        Between(1, 8));
}

void RectifyOptions::Visit(OptionVisitor& v) {
  v.Add(downsample, SharedOption("downsample", Everyday()));
  v.Add(max_depth_m, "max_depth_m", "larger depths are missing", Positive(), Everyday());
}

}  // namespace surfit
