// The options of this module.
#include "surfit/core/options.h"

#include <cmath>

#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

void FusionOptions::Visit(OptionVisitor& v) {
  v.Group("map");
  v.Add(weighting, "weighting", "weight of a point in the map; confidence is less off the centre",
        OneOf({"confidence", "uniform"}), AsFlag());
  v.Add(merge_distance_m, "merge_distance_m",
        "points merge with surfels at most this far along the normal", Positive(), AsFlag());
  v.Add(merge_angle_rad, "merge_angle_rad",
        "points merge with surfels whose normal differs by at most this", Positive(),
        Below(M_PI / 2), AsFlag());
  v.Add(max_spacing_m, "max_spacing_m",
        "points merge with surfels at most this far across the surface", Positive(), AsFlag());
  v.Add(duplicate_share, "duplicate_share",
        "of two surfels closer than this share of their radii, and of max_spacing_m, the less "
        "confident one is removed",
        ZeroIs("none"), AsFlag());
  v.Add(max_slant_scale, "max_slant_scale",
        "the radius grows by this factor at most on slanted surfaces", AtLeast(1));
  v.Add(max_radius_ratio, "max_radius_ratio",
        "points that are coarser by this factor do not move a surfel", Positive());
  v.Add(lasting_confidence, "lasting_confidence",
        "surfels of less confidence are removed when dormant", AtLeast(0), AsFlag());
  v.Add(max_dormant_frames, "max_dormant_frames",
        "surfels not seen in more fused frames are dormant for lasting_confidence", AtLeast(0),
        AsFlag());
  v.Add(max_confidence, "max_confidence", "confidence is limited so that the map can still change",
        Positive());
  v.Add(active_frames, "active_frames",
        "surfels not seen in this many fused frames are neither tracked against nor fused with; "
        "with loop_closure what loops need",
        ZeroIs("no limit"), AsFlag());
  v.Add(max_map_points, "max_map_points", "surfels in the map at most; those refused are counted",
        ZeroIs("no limit"), AsFlag());
  v.Add(free_space_margin_m, "free_space_margin_m",
        "surfels are removed where depth is measured farther behind them, plus 4 sigma", Positive(),
        AsFlag());
}

void RenderOptions::Visit(OptionVisitor& v) {
  v.Add(stable_confidence, "stable_confidence",
        "surfels of less confidence are drawn only where no others are", AtLeast(0));
  v.Add(radius_share, "radius_share", "a disc covers pixels within this share of its radius",
        Positive());
  v.Add(max_half_window_px, "max_half_window_px", "half the window of pixels that a disc may cover",
        Between(0, 64));
  v.Add(surface_thickness_m, "surface_thickness_m",
        "discs this far behind the first one, plus 4 sigma, are the same surface", AtLeast(0));
}

}  // namespace surfit
