// The options of this room.
#include "surfit/core/options.h"

#include "surfit/places/find_loops.h"
#include "surfit/places/keyframe.h"
#include "surfit/places/place_index.h"

namespace surfit {

void KeyframeOptions::Visit(OptionVisitor& v) {
  v.Group("keyframes");
  v.Add(max_distance_m,
        Option("max_distance_m", "a frame becomes a keyframe if the camera has moved this far,")
            .Positive()
            .Flag("keyframe_distance_m"));
  v.Add(max_angle_rad,
        Option("max_angle_rad", "has turned by this much,").Positive().Flag("keyframe_angle_rad"));
  v.Add(min_overlap_share,
        Option("min_overlap_share", "or sees less than this share of what the last keyframe saw,")
            .Share()
            .Flag("keyframe_overlap"));
  v.Add(
      max_frames,
      Option("max_frames", "or moved in this many frames, by a tenth of that at least").AtLeast(1));
}

void PlaceViewOptions::Visit(OptionVisitor& v) {
  v.Add(max_width, Option("max_width", "images are halved until no wider").AtLeast(80).Unit("px"));
  v.Add(max_features,
        Option("max_features", "features of a keyframe, spread over the image").AtLeast(48));
}

void PlaceIndexOptions::Visit(OptionVisitor& v) {
  v.Add(tables, Option("tables", "hash tables, each by other bits of a descriptor").From(1, 64));
  v.Add(bits, Option("bits", "bits that are the key of a table").From(1, 20));
  v.Add(max_hamming,
        Option("max_hamming", "descriptors that differ in more bits do not match").From(0, 256));
  v.Add(min_similarity, Option("min_similarity", "of a candidate").Share());
}

void VerifyLoopOptions::Visit(OptionVisitor& v) {
  v.AddPart(preprocess, Option("preprocess", "how the views get normals and coarser levels"));
  v.AddPart(icp, Option("icp", "the dense registration"));
  v.Add(min_agreeing_features,
        Option("min_agreeing_features", "features that must agree on a proposed pose").AtLeast(4));
  v.AddPart(fit, Option("fit", "what a fit must show"));
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
  v.Add(
      min_gap,
      Option("min_gap", "frames between the two keyframes of a loop").AtLeast(1).Flag("loop_gap"));
  v.Add(max_alike, Option("max_alike", "keyframes that are tried because they look most alike")
                       .AtLeast(0)
                       .Flag());
  v.Add(max_near,
        Option("max_near", "further keyframes that are tried because their poses are near")
            .AtLeast(0)
            .Flag());
  v.Add(max_near_m, Option("max_near_m", "near is no farther").AtLeast(0));
  v.Add(max_near_rad, Option("max_near_rad", "nor turned by more").AtLeast(0));
  v.AddPart(verify, Option("verify", "what a loop must show").NoFlags());
}

void RelocalizeOptions::Visit(OptionVisitor& v) {
  v.Add(max_candidates,
        Option("max_candidates", "keyframes that are tried, most alike first").AtLeast(1));
  v.AddPart(verify, Option("verify", "what the right one must show"));
}

}  // namespace surfit
