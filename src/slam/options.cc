// The options of this module.
#include "surfit/core/options.h"

#include "surfit/core/error.h"
#include "surfit/registration/far_registration.h"
#include "surfit/slam/slam.h"

namespace surfit {

void SlamOptions::Visit(OptionVisitor& v) {
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces");
  v.AddPart(icp, "icp", "registration of a frame to the map",
            WithoutFlags({"max_free_space_share"}));
  v.AddPart(fusion, "fusion", "how frames become surfels");
  v.AddPart(render, "render", "how the map is drawn for tracking", NoFlags());
  v.Group("tracking");
  v.Add(tracking, "tracking", "what a frame is registered to",
        OneOf({"frame_to_model", "frame_to_frame"}), AsFlag());
  v.Add(map_period, "map_period",
        "fuse every n-th tracked frame, and draw the map anew for every n-th; 1 = for all",
        AtLeast(1), Everyday());
  v.Add(max_view_shift, "max_view_shift",
        "draw the map anew, and fuse, where the image has moved by more since, as a share of its "
        "width",
        AtLeast(0), AsFlag());
  v.Add(min_turn_eigenvalue, "min_turn_eigenvalue",
        "after a frame whose data constrain a direction of motion less, ignore map_period and "
        "register all rows",
        ZeroIs("never"), AsFlag());
  v.Add(poorly_held_photometric_weight, "poorly_held_photometric_weight",
        "weight of intensity residuals after and in such a frame, where photometric_weight is 0",
        ZeroIs("surfaces only"), AsFlag());
  v.Add(
      motion_model, "motion_model",
      "pose that tracking starts at; so3: the last one, turned so that small images are most alike",
      OneOf({"constant_velocity", "constant_pose", "so3"}), AsFlag());
  v.Add(acceleration_m_per_s2, "acceleration_m_per_s2",
        "standard deviation of the camera's acceleration, which tells how it moves where the data "
        "do not; needs motion_model=constant_velocity",
        ZeroIs("the data alone tell"), AsFlag());
  v.Add(turn_acceleration_rad_per_s2, "turn_acceleration_rad_per_s2", "the same of how it turns",
        Positive(), AsFlag());
  v.Add(min_inlier_share, "min_inlier_share", "a frame with a smaller share of inliers is lost",
        Share(), AsFlag());
  v.Add(sure_inlier_share, "sure_inlier_share",
        "a frame with a smaller share of inliers is looked for by `initialize` as well", Share(),
        AsFlag());
  v.Add(max_rmse_m, "max_rmse_m", "a frame with larger residuals is lost", Positive(), AsFlag());
  v.Add(initialize, "initialize",
        "how a frame that would be lost is recovered from the last good one; identity: not at all",
        OneOf(InitializeMethods()), AsFlag());
  v.Add(hold_out, "hold_out",
        "leave the last of so many frames out of the map, to judge it by (surfit_evaluate "
        "--what=views)",
        ZeroIs("none"), AsFlag());
  v.AddPart(loops, "loops", "loop closure and relocalisation");
  v.AddPart(calibration, "calibration", "calibration of the depth camera");
  v.Add(real_time, "real_time",
        "let no frame wait for what is found of loops and the camera: it takes effect when it is "
        "there, and the result depends on the machine; always so with --offered_fps and cameras",
        AsFlag());
  v.Check([this] {
    if (hold_out == 1) throw InputError("hold_out is 1, must be 0 (none) or at least 2");
    if (acceleration_m_per_s2 > 0 && motion_model != "constant_velocity") {
      throw InputError(Concat("acceleration_m_per_s2 is ", acceleration_m_per_s2,
                              ", must be 0 where motion_model is ", motion_model));
    }
  });
}

}  // namespace surfit
