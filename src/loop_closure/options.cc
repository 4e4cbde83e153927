// The options of this module.
#include "surfit/core/options.h"

#include "surfit/loop_closure/find_loops.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"

namespace surfit {

void KeyframeOptions::Visit(OptionVisitor& v) {
  v.Group("keyframes");
  v.Add(max_distance_m, "max_distance_m",
        "a frame becomes a keyframe if the camera has moved this far,", Positive());
  v.Add(max_angle_rad, "max_angle_rad", "has turned by this much,", Positive());
  v.Add(min_overlap_share, "min_overlap_share",
        "or sees less than this share of what the last keyframe saw,", Share());
  v.Add(max_frames, "max_frames", "or moved in this many frames, by a tenth of that at least",
        AtLeast(1));
}

void PlaceViewOptions::Visit(OptionVisitor& v) {
  v.Add(max_width, "max_width", "images are halved until no wider", AtLeast(80), InUnit("px"));
  v.Add(max_features, "max_features", "features of a keyframe, spread over the image", AtLeast(48));
}

void PlaceIndexOptions::Visit(OptionVisitor& v) {
  v.Add(tables, "tables", "hash tables, each by other bits of a descriptor", Between(1, 64));
  v.Add(bits, "bits", "bits that are the key of a table", Between(1, 20));
  v.Add(max_hamming, "max_hamming", "descriptors that differ in more bits do not match",
        Between(0, 256));
  v.Add(min_similarity, "min_similarity", "of a candidate", Share());
}

void VerifyLoopOptions::Visit(OptionVisitor& v) {
  v.AddPart(preprocess, "preprocess", "how the views get normals and coarser levels");
  v.AddPart(icp, "icp", "the dense registration");
  v.Add(min_agreeing_features, "min_agreeing_features",
        "features that must agree on a proposed pose", AtLeast(4));
  v.AddPart(fit, "fit", "what a fit must show");
}

IcpOptions VerifyLoopOptions::DefaultIcp() {
  IcpOptions icp;
  icp.residual = "symmetric_point_to_plane";
  icp.gates.max_distance_m = 0.05;
  icp.gates.max_normal_angle_rad = 0.5;
  icp.max_iterations = 20;
  icp.stop_at_rmse_increase = false;
  icp.error_model.photometric_weight = 0.01;
  return icp;
}

void FindLoopsOptions::Visit(OptionVisitor& v) {
  v.Group("loops");
  v.Add(min_gap, "min_gap", "frames between the two keyframes of a loop", AtLeast(1));
  v.Add(max_alike, "max_alike", "keyframes that are tried because they look most alike",
        AtLeast(0));
  v.Add(max_near, "max_near", "further keyframes that are tried because their poses are near",
        AtLeast(0));
  v.Add(max_near_m, "max_near_m", "near is no farther", AtLeast(0));
  v.Add(max_near_rad, "max_near_rad", "nor turned by more", AtLeast(0));
  v.AddPart(verify, "verify", "what a loop must show", NoFlags());
}

void RelocalizeOptions::Visit(OptionVisitor& v) {
  v.Add(max_candidates, "max_candidates", "keyframes that are tried, most alike first", AtLeast(1));
  v.AddPart(verify, "verify", "what the right one must show");
}

}  // namespace surfit
