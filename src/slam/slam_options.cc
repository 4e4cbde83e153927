#include "surfit/core/error.h"
#include "surfit/registration/initialize.h"
#include "surfit/slam/slam.h"

namespace surfit {
namespace {

// Two parts may have options of one name: errors say whose it is.
template <typename Options>
void ValidatePart(const char* part, const Options& options) {
  try {
    options.Validate();
  } catch (const InputError& error) {
    throw InputError(Concat(part, ": ", error.what()));
  }
}

}  // namespace

void SlamOptions::Validate() const {
  ValidatePart("preprocess", preprocess);
  ValidatePart("icp", icp);
  ValidatePart("fusion", fusion);
  ValidatePart("render", render);
  ValidatePart("loops", loops);
  if (tracking != "frame_to_model" && tracking != "frame_to_frame") {
    throw InputError(
        Concat("tracking is '", tracking, "', must be one of: frame_to_model, frame_to_frame"));
  }
  if (motion_model != "constant_velocity" && motion_model != "constant_pose" &&
      motion_model != "so3") {
    throw InputError(Concat("motion_model is '", motion_model,
                            "', must be one of: constant_velocity, constant_pose, so3"));
  }
  if (!(min_turn_eigenvalue >= 0)) {
    throw InputError(
        Concat("min_turn_eigenvalue is ", min_turn_eigenvalue, ", must be zero or positive"));
  }
  if (map_period < 1)
    throw InputError(Concat("map_period is ", map_period, ", must be at least 1"));
  if (!(max_view_shift >= 0)) {
    throw InputError(Concat("max_view_shift is ", max_view_shift, ", must be zero or positive"));
  }
  InitializeOptions initialization;
  initialization.method = initialize;
  initialization.Validate();
  if (!(min_inlier_share >= 0 && min_inlier_share <= 1)) {
    throw InputError(Concat("min_inlier_share is ", min_inlier_share, ", must be from 0 to 1"));
  }
  if (!(max_rmse_m > 0)) {
    throw InputError(Concat("max_rmse_m is ", max_rmse_m, ", must be positive"));
  }
}

}  // namespace surfit
