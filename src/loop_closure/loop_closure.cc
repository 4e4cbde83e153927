#include "surfit/loop_closure/loop_closure.h"

#include "surfit/core/options.h"

namespace surfit {

void EdgeNoise::Visit(OptionVisitor& v) {
  v.Add(shared_points, "shared_points", "neighbouring points whose errors in odometry are one",
        AtLeast(1));
  v.Add(odometry_m, "odometry_m", "standard deviation between consecutive keyframes,", Positive());
  v.Add(odometry_rad, "odometry_rad", "of the rotation between them,", Positive());
  v.Add(odometry_share, "odometry_share", "and as a share of the way and turn between them",
        AtLeast(0));
  v.Add(loop_m, "loop_m", "standard deviation of a loop beyond its registration's,", Positive());
  v.Add(loop_rad, "loop_rad", "and of its rotation", Positive());
}

void LoopOptions::Visit(OptionVisitor& v) {
  v.Group("loops");
  v.Add(enabled, "enabled",
        "close loops: find places again, correct poses and map; a lost camera is relocalised "
        "anywhere in the map",
        AsFlag("loop_closure"), Everyday());
  v.AddPart(keyframes, "keyframes", "when a frame becomes a keyframe", NoFlags());
  v.AddPart(views, "views", "what is kept of a keyframe", NoFlags());
  v.AddPart(places, "places", "how places are looked up", NoFlags());
  v.AddPart(find, "find", "which keyframes may be joined", NoFlags());
  v.AddPart(relocalize, "relocalize", "how a lost camera is found", NoFlags());
  v.AddPart(noise, "noise", "uncertainty of the pose graph's edges", NoFlags());
  v.AddPart(graph, "graph", "how the pose graph is optimised", NoFlags());
  v.Add(delay_frames, "delay_frames", "frames from a keyframe until its loops take effect",
        AtLeast(1));
  v.Add(active_frames, "active_frames", "FusionOptions.active_frames where that sets no limit",
        ZeroIs("no limit"));
  v.Add(frames_apart, "frames_apart",
        "surfels seen this far apart in time are merged where a loop joins them", AtLeast(1));
  v.Add(min_correction_m, "min_correction_m", "smaller corrections are not applied", AtLeast(0));
  v.Add(max_view_bytes, "max_view_bytes", "memory for the keyframes' views");
  v.Add(new_map_after, "new_map_after",
        "with loop_closure: begin a new map after this many lost frames in a row, to be joined to "
        "the first by a loop",
        ZeroIs("never"), AsFlag());
}

}  // namespace surfit
