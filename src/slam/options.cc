#include "surfit/core/options.h"

#include "surfit/core/error.h"
#include "surfit/registration/global_registration.h"
#include "surfit/slam/slam.h"

namespace surfit {

void SlamOptions::Visit(OptionVisitor& v) {
  v.AddPart(preprocess, "preprocess", "preprocessing of depth images");
  v.AddPart(icp, "icp", "registration of frames to the map");
  v.AddPart(fusion, "fusion", "fusion of frames into the map");
  v.AddPart(render, "render", "rendering of the map for tracking", NoFlags());
  v.Group("tracking");
  v.Add(tracking, "tracking", "target of the registration of a frame",
        OneOf({"frame_to_model", "frame_to_frame"}), AsFlag());
  v.Add(map_period, "map_period",
        "fuse every n-th tracked frame, and render a new model view for every n-th frame; 1: all "
        "frames",
        AtLeast(1));
  v.Add(max_view_shift, "max_view_shift",
        "image shift that triggers a new model view and fusion, as a ratio of the image width",
        AtLeast(0));
  v.Add(
      min_turn_eigenvalue, "min_turn_eigenvalue",
      "minimum eigenvalue of a sufficiently constrained frame; a frame after a weakly constrained "
      "frame is fused and registered without subsampling",
      ZeroIs("never"));
  v.Add(weakly_constrained_photometric_weight, "weakly_constrained_photometric_weight",
        "photometric weight of weakly constrained frames and of the next frame, if "
        "photometric_weight is 0",
        ZeroIs("geometric residuals only"));
  v.Add(acceleration_m_per_s2, "acceleration_m_per_s2",
        "standard deviation of the acceleration in the motion prior, which constrains directions "
        "that the data do not",
        ZeroIs("3, for weakly constrained frames only"));
  v.Add(angular_acceleration_rad_per_s2, "angular_acceleration_rad_per_s2",
        "standard deviation of the angular acceleration in the motion prior", Positive());
  v.Add(min_inlier_ratio, "min_inlier_ratio",
        "minimum inlier ratio of a tracked frame; frames below are lost", Share());
  v.Add(
      confident_inlier_ratio, "confident_inlier_ratio",
      "inlier ratio below which a search from the last frame verifies a frame; 0: only lost frames",
      Share());
  v.Add(max_rmse_m, "max_rmse_m", "maximum residual RMSE of a tracked frame; frames above are lost",
        Positive());
  v.Add(initialize, "initialize",
        "global registration of lost frames to the last tracked frame; identity: none",
        OneOf(InitializeMethods()));
  v.Add(hold_out, "hold_out",
        "exclude every n-th frame from fusion, to evaluate views of the map with surfit_evaluate",
        ZeroIs("none"), AsFlag());
  v.AddPart(loops, "loops", "loop closure and relocalisation");
  v.AddPart(calibration, "calibration", "calibration of the depth camera");
  v.Add(real_time, "real_time",
        "do not wait for loop closure and calibration; the result depends on the machine; always "
        "on with --offered_fps and cameras");
  v.Check([this] {
    if (hold_out == 1) throw InputError("hold_out is 1, must be 0 (none) or at least 2");
  });
}

}  // namespace surfit
