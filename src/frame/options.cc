// The options of this room.
#include "surfit/core/options.h"

#include "surfit/frame/prepare_frame.h"
#include "surfit/frame/preprocess.h"

namespace surfit {

void PreprocessOptions::Visit(OptionVisitor& v) {
  v.Group("surfaces");
  v.Add(filter_radius_px, Option("filter_radius_px", "half the window of the depth filter")
                              .From(0, 7)
                              .Zero("no filter")
                              .Unit("px")
                              .Flag("depth_filter_radius"));
  v.Add(filter_cutoff,
        Option("filter_cutoff", "depths that differ by more sigmas have no weight in the filter")
            .Positive()
            .Below(1000));
  v.Add(normal_radius_px, Option("normal_radius_px", "normals come from depths this far around")
                              .From(1, 7)
                              .Unit("px")
                              .Flag("normal_radius"));
  v.Add(max_slant_rad,
        Option("max_slant_rad", "surfaces at a larger angle to the ray are taken for depth edges")
            .Positive()
            .Below(1.57));
  v.Add(pyramid_levels,
        Option("pyramid_levels", "resolutions to register on, as far as the image allows")
            .From(1, 8)
            .Flag());
}

void PrepareOptions::Visit(OptionVisitor& v) {
  v.Add(downsample, Option("downsample", "keep every n-th column and row").From(1, 16).Everyday());
  v.Add(max_depth_m, Option("max_depth_m", "larger depths count as missing").Positive().Everyday());
}

}  // namespace surfit
