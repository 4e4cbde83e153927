#include "surfit/core/options.h"

#include <algorithm>

#include "surfit/core/error.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"

namespace surfit {

void KinectOptions::Visit(OptionVisitor& v) {
  v.Add(shift_sd_px, "shift_sd_px", "standard deviation of the random pixel shift", AtLeast(0));
  v.Add(disparity_sd, "disparity_sd",
        "standard deviation of the disparity noise, in quantisation steps", AtLeast(0));
  v.Add(disparity_times_z_cm, "disparity_times_z_cm",
        "product of the disparity, in quantisation steps, and the depth, in cm", Positive());
  v.Add(min_depth_m, "min_depth_m", "minimum depth; smaller depth is missing", Positive());
  v.Add(max_depth_m, "max_depth_m", "maximum depth; larger depth is missing", Positive());
  v.Add(max_incidence_deg, "max_incidence_deg",
        "maximum angle between ray and surface normal (beyond: missing depth)", Positive(),
        Between(0, 90));
  v.Add(max_edge_ratio, "max_edge_ratio",
        "maximum relative depth difference that a pixel shift may cross", AtLeast(0));
  v.Check([this] {
    if (max_depth_m > min_depth_m) return;
    throw InputError("max_depth_m is ", max_depth_m, ", must be above min_depth_m");
  });
}

void ColorOptions::Visit(OptionVisitor& v) {
  v.Add(color_readout_s, "color_readout_s",
        "time from the first row of the colour rolling shutter, at the top, to the last row",
        Between(0, 1), InUnit("s"), AsFlag());
  v.Add(exposure_s, "exposure_s", "colour exposure time (0: no motion blur)", Between(0, 1),
        InUnit("s"), AsFlag());
  v.Add(exposure_samples, "exposure_samples", "number of rendered images per exposure",
        Between(1, 1000));
  v.Add(auto_exposure_lag_s, "auto_exposure_lag_s", "time constant of automatic exposure",
        AtLeast(0), ZeroIs("fixed"), AsFlag());
  v.Add(auto_white_balance_lag_s, "auto_white_balance_lag_s",
        "time constant of automatic white balance", AtLeast(0), ZeroIs("fixed"), AsFlag());
  v.Add(channel_gains, "channel_gains", "additional gains of red,green,blue; empty: 1,1,1",
        AsFlag());
  v.Check([this] {
    const bool are_positive =
        std::all_of(channel_gains.begin(), channel_gains.end(), [](double g) { return g > 0; });
    if ((channel_gains.empty() || channel_gains.size() == 3) && are_positive) return;
    throw InputError("channel_gains is ", OptionToText(channel_gains),
                     ", must be three positive numbers");
  });
}

void PathOptions::Visit(OptionVisitor& v) {
  v.Add(frames_per_second, "frames_per_second", "frames per second of the timestamps", Positive());
  v.Add(min_step_m, "min_step_m", "minimum translation between consecutive frames", Positive());
  v.Add(max_step_m, "max_step_m", "maximum translation between consecutive frames", Positive());
  v.Add(min_turn_deg, "min_turn_deg", "minimum rotation between consecutive frames", Positive());
  v.Add(max_turn_deg, "max_turn_deg", "maximum rotation between consecutive frames", Positive());
  v.Check([this] {
    ThrowIf(!(max_step_m >= min_step_m), "max_step_m is ", max_step_m,
            ", must be at least min_step_m");
    ThrowIf(!(max_turn_deg >= min_turn_deg), "max_turn_deg is ", max_turn_deg,
            ", must be at least min_turn_deg");
  });
}

}  // namespace surfit
