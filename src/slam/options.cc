// The options of this room.
#include "surfit/core/options.h"

#include "surfit/registration/far_registration.h"
#include "surfit/slam/slam.h"

namespace surfit {

void EdgeNoise::Visit(OptionVisitor& v) {
  v.Add(shared_points,
        Option("shared_points", "neighbouring points whose errors in odometry are one").AtLeast(1));
  v.Add(odometry_m,
        Option("odometry_m", "standard deviation between consecutive keyframes,").Positive());
  v.Add(odometry_rad, Option("odometry_rad", "of the rotation between them,").Positive());
  v.Add(odometry_share,
        Option("odometry_share", "and as a share of the way and turn between them").AtLeast(0));
  v.Add(loop_m,
        Option("loop_m", "standard deviation of a loop beyond its registration's,").Positive());
  v.Add(loop_rad, Option("loop_rad", "and of its rotation").Positive());
}

void LoopOptions::Visit(OptionVisitor& v) {
  v.Group("loops");
  v.Add(enabled, Option("enabled",
                        "close loops: find places again, correct poses and map; a lost camera is "
                        "relocalised anywhere in the map")
                     .Flag("loop_closure")
                     .Everyday());
  v.AddPart(keyframes, Option("keyframes", "when a frame becomes a keyframe").NoFlags());
  v.AddPart(views, Option("views", "what is kept of a keyframe").NoFlags());
  v.AddPart(places, Option("places", "how places are looked up").NoFlags());
  v.AddPart(find, Option("find", "which keyframes may be joined").NoFlags());
  v.AddPart(relocalize, Option("relocalize", "how a lost camera is found").NoFlags());
  v.AddPart(noise, Option("noise", "uncertainty of the pose graph's edges").NoFlags());
  v.AddPart(graph, Option("graph", "how the pose graph is optimised").NoFlags());
  v.Add(delay_frames,
        Option("delay_frames", "frames from a keyframe until its loops take effect").AtLeast(1));
  v.Add(active_frames,
        Option("active_frames", "FusionOptions.active_frames where that sets no limit")
            .Zero("no limit"));
  v.Add(frames_apart,
        Option("frames_apart",
               "surfels seen this far apart in time are merged where a loop joins them")
            .AtLeast(1));
  v.Add(min_correction_m,
        Option("min_correction_m", "smaller corrections are not applied").AtLeast(0));
  v.Add(max_view_bytes, Option("max_view_bytes", "memory for the keyframes' views"));
  v.Add(new_map_after,
        Option("new_map_after",
               "with loop_closure: begin a new map after this many lost frames in a row, to be "
               "joined to the first by a loop")
            .Zero("never")
            .Flag());
}

void SlamOptions::Visit(OptionVisitor& v) {
  v.AddPart(preprocess, Option("preprocess", "how depth images become surfaces"));
  v.AddPart(
      icp,
      Option("icp", "registration of a frame to the map").WithoutFlags({"max_free_space_share"}));
  v.AddPart(fusion, Option("fusion", "how frames become surfels"));
  v.AddPart(render, Option("render", "how the map is drawn for tracking").NoFlags());
  v.Group("tracking");
  v.Add(tracking, Option("tracking", "what a frame is registered to")
                      .OneOf({"frame_to_model", "frame_to_frame"})
                      .Flag());
  v.Add(map_period,
        Option("map_period",
               "fuse every n-th tracked frame, and draw the map anew for every n-th; 1 = for all")
            .AtLeast(1)
            .Everyday());
  v.Add(max_view_shift,
        Option("max_view_shift",
               "draw the map anew where the image is expected to have moved by more, as a share of "
               "its width")
            .AtLeast(0)
            .Flag());
  v.Add(min_turn_eigenvalue,
        Option("min_turn_eigenvalue",
               "after a frame whose data constrain a direction of motion less, ignore map_period "
               "and register all rows")
            .Zero("never")
            .Flag());
  v.Add(motion_model,
        Option("motion_model",
               "pose that tracking starts at; so3: the last one, turned so that small images are "
               "most alike")
            .OneOf({"constant_velocity", "constant_pose", "so3"})
            .Flag());
  v.Add(
      min_inlier_share,
      Option("min_inlier_share", "a frame with a smaller share of inliers is lost").Share().Flag());
  v.Add(max_rmse_m,
        Option("max_rmse_m", "a frame with larger residuals is lost").Positive().Flag());
  v.Add(initialize,
        Option("initialize",
               "how a frame that would be lost is recovered from the last good one; identity: not "
               "at all")
            .OneOf(InitializeMethods())
            .Flag());
  v.AddPart(loops, Option("loops", "loop closure and relocalisation"));
}

}  // namespace surfit
