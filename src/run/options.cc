// The options of this room.
#include "surfit/core/options.h"

#include "run/pose_problem.h"
#include "run/posed_views.h"
#include "run/view_files.h"
#include "surfit/core/error.h"
#include "surfit/run/check_recording.h"
#include "surfit/run/refine_run.h"
#include "surfit/run/register_run.h"
#include "surfit/run/revisits.h"
#include "surfit/run/slam_run.h"
#include "surfit/run/view_evaluation.h"

namespace surfit {
namespace {

Option Output(const std::string& what) {
  return Option("output", what + "; made if missing", Required(), Everyday());
}

Option Threads() {
  return Option("threads", "threads that compute at the same time", Between(1, 1024), Everyday());
}

}  // namespace

void SlamRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read");
  v.Group("run");
  v.Add(output, Output("folder for the results"));
  v.Add(threads, Threads());
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
  v.Add(pictures, "pictures", "write pictures of map and trajectory", AsFlag());
  v.Add(keep_views, "keep_views",
        "write report.html: map and trajectory in 3D, plots, views, options", AsFlag("report"),
        Everyday());
  v.Add(keep_places, "keep_places",
        "with loop_closure: write places.bin, keyframes with their views and all edges of the pose "
        "graph, to be joined to other runs",
        AsFlag());
  v.Add(session, "session",
        "folder of a session: what the run knows is kept there as it goes, with loops closed",
        AsFlag(), Everyday());
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

void RecordingCheckOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read");
  v.Group("run");
  v.Add(track, "track",
        "track the camera, which tells of its calibration and of the latency of colour", AsFlag(),
        Everyday());
  v.Add(threads, Threads());
}

void RefineRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "as the run read it");
  v.Group("run");
  v.Add(trajectory, "trajectory", "the run's trajectory, in TUM format", Required());
  v.Add(output, Output("folder for the results"));
  v.Add(threads, Threads());
  v.Group("keyframes");
  v.Add(keyframe_translation_m, "keyframe_translation_m",
        "a frame this far from the last keyframe is the next", Positive(), AsFlag());
  v.Add(keyframe_rotation_rad, "keyframe_rotation_rad", "and so is a frame turned this far",
        Positive(), AsFlag());
  v.Add(max_keyframes, "max_keyframes", "with more of them, both are enlarged", ZeroIs("no limit"),
        AsFlag());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces", NoFlags());
  v.AddPart(refinement, "refinement", "what is estimated, and how");
  v.Check([this] {
    if (max_keyframes != 1) return;
    throw InputError("max_keyframes is 1, must be 0 (no limit) or at least 2");
  });
}

void RegisterRunOptions::Visit(OptionVisitor& v) {
  v.Group("clouds");
  v.Add(source, "source", "the cloud to be moved: PLY or PCD, in m", Required(), Everyday());
  v.Add(target, "target", "the cloud to be met", Required(), Everyday());
  v.Group("run");
  v.Add(output, Output("folder for pose, aligned cloud and pictures"));
  v.Add(threads, Threads());
  v.AddPart(sensor, "sensor", "what both were measured with");
  v.AddPart(normals, "normals", "how normals are estimated");
  v.AddPart(registration, "registration", "how the clouds are registered");
}

void AlignRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read", WithoutFlags({"first", "last", "stride"}));
  v.Add(source, "source", "index of the frame to be moved", AtLeast(0), Everyday());
  v.Add(target, "target", "index of the frame to be met", AtLeast(0), Everyday());
  v.Group("run");
  v.Add(output, Output("folder for clouds and pictures"));
  v.Add(threads, Threads());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces");
  v.AddPart(initialize, "initialize", "where registration starts");
  v.AddPart(icp, "icp", "the registration", WithoutFlags({"min_source_rows"}));
}

void RevisitOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read", WithoutFlags({"first", "last"}));
  v.Group("revisits");
  v.Add(estimate, "estimate", "the estimated trajectory of the sequence, in TUM format", Required(),
        Everyday());
  v.Add(min_gap, "min_gap", "frames between two visits", AtLeast(1), Everyday());
  v.Add(max_distance_m, "max_distance_m", "distance of the two cameras at most", Positive(),
        Everyday());
  v.Add(max_angle_rad, "max_angle_rad", "angle between the two cameras at most", Positive(),
        Everyday());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces", NoFlags());
}

void ViewEvaluationOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "as the run read it");
  v.Group("views");
  v.Add(run, "run",
        "output folder of surfit_slam; its summary.json says which sequence it read and how, where "
        "flags do not, and its poses.json what camera it found",
        Required(), Everyday());
  v.Add(output, "output", "folder for the results, made if missing; empty: the run's", Everyday());
  v.Add(every, "every", "judge by every n-th frame; a run with --hold_out by what it held out",
        AtLeast(1), Everyday());
  v.Add(pictures, "pictures", "write pictures of so many views, the worst first",
        Between(0, kMostViewPictures), Everyday());
  v.Add(threads, Threads());
}

void FindLoopsRunOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read", WithoutFlags({"first", "last", "stride"}));
  v.Group("run");
  v.Add(trajectory, "trajectory", "the estimated trajectory, in TUM format", Required(),
        Everyday());
  v.Add(output, Output("folder for loops.csv and loops.g2o"));
  v.Add(threads, Threads());
  v.AddPart(preprocess, "preprocess", "how depth images become surfaces", NoFlags());
  v.AddPart(keyframes, "keyframes", "when a frame becomes a keyframe");
  v.AddPart(view, "view", "what is kept of a keyframe");
  v.AddPart(index, "index", "how places are looked up");
  v.AddPart(loops, "loops", "which keyframes may be joined");
  v.Group("loops");
  v.Add(max_view_bytes, "max_view_bytes",
        "memory for all keyframes' views; beyond, views of places that others show as well are "
        "given up",
        AsFlag());
  v.Group("evaluation");
  v.Add(revisit_gap, "revisit_gap",
        "a frame returns if its true pose is near that of a frame this much earlier", AtLeast(1),
        AsFlag());
  v.Add(revisit_m, "revisit_m", "distance that is near", Positive(), AsFlag("revisit_distance_m"));
  v.Add(revisit_rad, "revisit_rad", "angle that is near", Positive(), AsFlag("revisit_angle_rad"));
  v.Add(wrong_m, "wrong_m", "a loop farther from the truth is wrong", Positive());
  v.Add(wrong_rad, "wrong_rad", "and so is one turned farther", Positive());
}

}  // namespace surfit
