// The options of this module.
#include "surfit/core/options.h"

#include <algorithm>

#include "surfit/core/error.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"

namespace surfit {

void KinectOptions::Visit(OptionVisitor& v) {
  v.Add(shift_sd_px, "shift_sd_px", "random shift of each pixel", AtLeast(0));
  v.Add(disparity_sd, "disparity_sd", "in quantisation steps", AtLeast(0));
  v.Add(disparity_times_z_cm, "disparity_times_z_cm", "number of a disparity step, times depth",
        Positive());
  v.Add(min_depth_m, "min_depth_m", "nearer is missing", Positive());
  v.Add(max_depth_m, "max_depth_m", "farther is missing", Positive());
  v.Add(max_incidence_deg, "max_incidence_deg", "seen more obliquely is missing", Positive(),
        Between(0, 90));
  v.Add(max_edge_ratio, "max_edge_ratio",
        "shifts do not cross steps of depth beyond this share of the depth", AtLeast(0));
  v.Check([this] {
    if (max_depth_m > min_depth_m) return;
    throw InputError("max_depth_m is ", max_depth_m, ", must be above min_depth_m");
  });
}

void ColorOptions::Visit(OptionVisitor& v) {
  v.Add(color_readout_s, "color_readout_s",
        "of colour's rolling shutter: from the first row that is read, at the top, to the last",
        Between(0, 1), InUnit("s"), AsFlag());
  v.Add(exposure_s, "exposure_s", "colour gathers light for so long: blur", Between(0, 1),
        InUnit("s"), AsFlag());
  v.Add(exposure_samples, "exposure_samples",
        "moments of the exposure whose light is rendered and averaged", Between(1, 1000), AsFlag());
  v.Add(auto_exposure_lag_s, "auto_exposure_lag_s",
        "the exposure follows the image's brightness with this time constant", AtLeast(0),
        ZeroIs("fixed"), AsFlag());
  v.Add(auto_white_balance_lag_s, "auto_white_balance_lag_s",
        "and the gains of the channels its tint", AtLeast(0), ZeroIs("fixed"), AsFlag());
  v.Add(channel_gains, "channel_gains",
        "what red,green,blue are multiplied by besides; empty = 1,1,1", AsFlag());
  v.Check([this] {
    const bool are_positive =
        std::all_of(channel_gains.begin(), channel_gains.end(), [](double g) { return g > 0; });
    if ((channel_gains.empty() || channel_gains.size() == 3) && are_positive) return;
    throw InputError("channel_gains is ", OptionToText(channel_gains),
                     ", must be three positive numbers");
  });
}

void PathOptions::Visit(OptionVisitor& v) {
  v.Add(frames_per_second, "frames_per_second", "of the stamps", Positive());
  v.Add(min_step_m, "min_step_m", "between consecutive frames at least", Positive(), AsFlag());
  v.Add(max_step_m, "max_step_m", "between consecutive frames at most", Positive(), AsFlag());
  v.Add(min_turn_deg, "min_turn_deg", "between consecutive frames at least", Positive());
  v.Add(max_turn_deg, "max_turn_deg", "between consecutive frames at most", Positive());
  v.Check([this] {
    ThrowIf(!(max_step_m >= min_step_m), "max_step_m is ", max_step_m,
            ", must not be below min_step_m");
    ThrowIf(!(max_turn_deg >= min_turn_deg), "max_turn_deg is ", max_turn_deg,
            ", must not be below min_turn_deg");
  });
}

}  // namespace surfit
