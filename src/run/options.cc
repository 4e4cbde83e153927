#include "surfit/core/options.h"

#include "core/shared_options.h"
#include "run/posed_views.h"
#include "surfit/core/error.h"
#include "surfit/run/slam_run.h"

namespace surfit {

void SlamRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read");
  v.Group("run");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(slam, "slam", "how the SLAM works");
  v.Add(initial_pose, "initial_pose",
        "pose of the first frame: identity, groundtruth or tx,ty,tz,qx,qy,qz,qw", AsFlag());
  v.Add(poses, "poses", "track the camera; groundtruth: fuse along the sequence's own poses",
        OneOf({"track", "groundtruth"}), AsFlag());
  v.Add(queue_capacity, "queue_capacity", "frames that are read ahead, or offered and kept",
        Between(1, 1000));
  v.Add(offered_fps, "offered_fps",
        "offer frames at this rate, as a camera does; those not taken in time are dropped and "
        "counted, and only lost ones are looked for (sure_inlier_share is 0)",
        ZeroIs("as fast as they are processed"), AsFlag());
  v.Add(
      refine, "refine",
      "in the end, before the final map, refine poses and camera jointly by keyframes of the whole "
      "sequence, where the camera was found not to be as given; surfit_refine has more options",
      AsFlag(), Everyday());
  v.Add(final_map, "final_map",
        "in the end read the sequence once more, and fuse the map anew along the final poses, by "
        "the calibration that was found",
        AsFlag());
  v.Add(groundtruth, SharedOption("groundtruth"));
  v.Add(fit_mount, SharedOption("fit_mount"));
  v.Add(pictures, SharedOption("pictures"));
  v.Add(keep_views, "keep_views",
        "write report.html: map and trajectory in 3D, plots, views, options", AsFlag("report"),
        Everyday());
  v.Add(keep_places, "keep_places",
        "with loop_closure: write places.bin, keyframes with their views and all edges of the pose "
        "graph, to be joined to other runs",
        AsFlag());
  v.Add(session, SharedOption("session", Everyday()));
  v.Add(continue_session, "continue_session",
        "go on in the session where it has ended, or wherever in it the camera is found",
        AsFlag("continue"), Everyday());
  v.Add(localize, "localize", "find the camera in the session, and leave that as it is", AsFlag(),
        Everyday());
  v.Add(trace, "trace", "file for the times of all stages and threads, for ui.perfetto.dev",
        AsFlag());
  v.Add(dump_failures, "dump_failures",
        "folder for what tracking lost a frame with, for surfit_compare_solvers --replay",
        AsFlag());
  v.Check([this] {
    if (slam.loops.enabled && poses != "track") {
      throw InputError(Concat("poses is '", poses, "', must be 'track' where loops are closed"));
    }
    if (keep_places && !slam.loops.enabled) {
      throw InputError("keep_places is true, must be false without loop_closure");
    }
    if (session.empty() && (continue_session || localize)) {
      throw InputError(Concat(continue_session ? "continue" : "localize",
                              " is true, must be false without a session"));
    }
    if (continue_session && localize) {
      throw InputError("localize is true, must be false where the session is continued");
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
