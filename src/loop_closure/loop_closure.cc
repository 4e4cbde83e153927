#include "surfit/loop_closure/loop_closure.h"

#include "surfit/core/options.h"

namespace surfit {

void EdgeNoise::Visit(OptionVisitor& v) {
  v.Add(shared_points, "shared_points",
        "number of neighbouring points with fully correlated odometry errors", AtLeast(1));
  v.Add(odometry_m, "odometry_m",
        "standard deviation of the translation between consecutive keyframes", Positive());
  v.Add(odometry_rad, "odometry_rad",
        "standard deviation of the rotation between consecutive keyframes", Positive());
  v.Add(
      odometry_ratio, "odometry_ratio",
      "additional standard deviation, as a ratio of the translation and rotation between keyframes",
      AtLeast(0));
  v.Add(loop_m, "loop_m",
        "standard deviation of the translation of a loop closure, in addition to its registration",
        Positive());
  v.Add(loop_rad, "loop_rad",
        "standard deviation of the rotation of a loop closure, in addition to its registration",
        Positive());
}

void LoopOptions::Visit(OptionVisitor& v) {
  v.Group("loops");
  v.Add(enabled, "enabled",
        "close loops: correct poses and map where the camera returns; no effect on given poses",
        AsFlag("loop_closure"), Everyday());
  v.Add(relocalization, "relocalization",
        "relocalise a lost camera anywhere in the map, and start a submap if that fails; "
        "loop_closure implies it");
  v.AddPart(keyframes, "keyframes", "selection of keyframes", NoFlags());
  v.AddPart(views, "views", "stored views of keyframes", NoFlags());
  v.AddPart(places, "places", "place recognition", NoFlags());
  v.AddPart(find, "find", "search for loop closures", NoFlags());
  v.AddPart(relocalize, "relocalize", "relocalisation", NoFlags());
  v.AddPart(noise, "noise", "uncertainty of the pose graph's edges", NoFlags());
  v.AddPart(graph, "graph", "optimisation of the pose graph", NoFlags());
  v.Add(delay_frames, "delay_frames",
        "number of frames from a keyframe to the correction by its loop closures", AtLeast(1));
  v.Add(active_frames, "active_frames",
        "FusionOptions.active_frames with loop closure, if that option is 0", ZeroIs("no limit"));
  v.Add(frames_apart, "frames_apart",
        "minimum number of frames between the observations of duplicate surfels that a loop "
        "closure merges",
        AtLeast(1));
  v.Add(max_view_bytes, "max_view_bytes", "memory of keyframe views");
  v.Add(new_map_after, "new_map_after",
        "number of consecutive lost frames with depth until a new submap starts; a loop closure "
        "connects it to the first submap",
        ZeroIs("never"), AsFlag());
}

}  // namespace surfit
