#include "surfit/core/options.h"

#include "core/shared_options.h"
#include "run/posed_views.h"
#include "surfit/core/error.h"
#include "surfit/run/slam_run.h"

namespace surfit {

void SlamRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "input sequence");
  v.Group("run");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(slam, "slam", "SLAM pipeline");
  v.Add(initial_pose, "initial_pose",
        "pose of the first frame: identity, groundtruth or tx,ty,tz,qx,qy,qz,qw", AsFlag());
  v.Add(poses, "poses", "track: estimate the poses; groundtruth: fuse at the ground-truth poses",
        OneOf({"track", "groundtruth"}), AsFlag());
  v.Add(queue_capacity, "queue_capacity",
        "frames to read ahead; with offered_fps or a camera: size of the queue", Between(1, 1000));
  v.Add(offered_fps, "offered_fps",
        "play the sequence at this rate, Hz, like a live camera; frames beyond "
        "queue_capacity are dropped and counted, and confident_inlier_ratio is 0",
        ZeroIs("as fast as frames are processed"), AsFlag());
  v.Add(refine, "refine",
        "if the run has changed the calibration, refine it jointly with the poses before the final "
        "map. Register the frames to the final map. surfit_refine has more options",
        AsFlag(), Everyday());
  v.Add(final_map, "final_map",
        "after the last frame, read the sequence again and fuse a new map with the final poses and "
        "the estimated calibration",
        AsFlag());
  v.Add(stereo, "stereo",
        "with final_map: add surfaces that only colour images show, such as monitors and glossy "
        "tables, by multi-view stereo",
        AsFlag());
  v.Add(groundtruth, SharedOption("groundtruth"));
  v.Add(fit_mount, SharedOption("fit_mount"));
  v.Add(prior_poses, "prior_poses",
        "trajectory of another source (phone, robot, other SLAM), TUM format: predicts and "
        "constrains the poses; its offset from the camera is fitted",
        AsFlag());
  v.Add(pictures, SharedOption("pictures"));
  v.Add(world, SharedOption("world", OneOf({"upright", "run"})));
  v.Add(keep_views, "keep_views",
        "write report.html: map and trajectory in 3D, plots, views, options", AsFlag("report"),
        Everyday());
  v.Add(keep_places, "keep_places",
        "write places.bin (keyframe views and pose graph edges), for joining "
        "several runs",
        AsFlag());
  v.Add(session, SharedOption("session", Everyday()));
  v.Add(continue_session, "continue_session",
        "continue the session, after its last frame or at the pose found by relocalisation",
        AsFlag("continue"), Everyday());
  v.Add(localize, "localize", "localise the camera in the session without changing the session",
        AsFlag(), Everyday());
  v.Add(trace, "trace", "trace file with the times of all stages and threads, for ui.perfetto.dev",
        AsFlag());
  v.Add(dump_failures, "dump_failures",
        "folder for failed registrations, input of surfit_compare_solvers --replay", AsFlag());
  v.Check([this] {
    if (!prior_poses.empty() && poses != "track") {
      throw InputError(
          Concat("prior_poses is '", prior_poses, "', must be empty with poses '", poses, "'"));
    }
    if (keep_places && (!slam.loops.enabled || poses != "track")) {
      throw InputError(
          "keep_places is true, must be false without loop_closure or with poses other than "
          "'track'");
    }
    if (session.empty() && (continue_session || localize)) {
      throw InputError(Concat(continue_session ? "continue" : "localize",
                              " is true, must be false without a session"));
    }
    if (continue_session && localize) {
      throw InputError("localize is true, must be false with continue");
    }
    if (!session.empty() && (poses != "track" || slam.tracking != "frame_to_model")) {
      throw InputError(Concat("session is '", session,
                              "', must be empty unless poses is 'track' and tracking is "
                              "'frame_to_model'"));
    }
    if (initial_pose != "identity" && initial_pose != "groundtruth") {
      ParsePose("initial_pose", initial_pose);
    }
    if (offered_fps > 0 && IsLive(sequence)) {
      throw InputError(Concat("offered_fps is ", offered_fps, ", must be 0 with format '",
                              sequence.format, "'"));
    }
  });
}

}  // namespace surfit
