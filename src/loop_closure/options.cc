#include "surfit/core/options.h"

#include "surfit/loop_closure/find_loops.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"

namespace surfit {

void KeyframeOptions::Visit(OptionVisitor& v) {
  v.Group("keyframes");
  v.Add(max_distance_m, "max_distance_m", "distance between keyframes", Positive());
  v.Add(max_angle_rad, "max_angle_rad", "rotation between keyframes", Positive());
  v.Add(min_overlap_ratio, "min_overlap_ratio", "minimum overlap with the last keyframe", Share());
  v.Add(max_frames, "max_frames", "maximum number of frames between keyframes of a moving camera",
        AtLeast(1));
}

void PlaceViewOptions::Visit(OptionVisitor& v) {
  v.Add(max_width, "max_width",
        "maximum width of keyframe images; larger images are halved until they fit", AtLeast(80),
        InUnit("px"));
  v.Add(max_features, "max_features", "maximum number of features per keyframe", AtLeast(48));
}

void PlaceIndexOptions::Visit(OptionVisitor& v) {
  v.Add(min_similarity, "min_similarity", "minimum similarity of a loop candidate", Share());
}

void VerifyLoopOptions::Visit(OptionVisitor& v) {
  v.AddPart(preprocess, "preprocess", "normals and pyramids of the views");
  v.AddPart(icp, "icp", "dense registration of the views");
  v.AddPart(fit, "fit", "acceptance criteria");
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
  v.Add(min_gap, "min_gap", "minimum number of frames between the keyframes of a loop closure",
        AtLeast(1));
  v.Add(max_similar, "max_similar", "maximum number of loop candidates from place recognition",
        AtLeast(0));
  v.Add(max_near, "max_near", "maximum number of additional loop candidates with near poses",
        AtLeast(0));
  v.AddPart(verify, "verify", "verification of loop candidates", NoFlags());
}

void RelocalizeOptions::Visit(OptionVisitor& v) {
  v.Add(max_candidates, "max_candidates",
        "maximum number of keyframes to verify, by descending similarity", AtLeast(1));
  v.Add(first_candidate, "first_candidate",
        "rank of the first keyframe to verify, modulo the number of similar keyframes", AtLeast(0));
  v.AddPart(verify, "verify", "verification of candidates");
}

}  // namespace surfit
