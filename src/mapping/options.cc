// The options of this room.
#include "surfit/core/options.h"

#include <cmath>

#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

void FusionOptions::Visit(OptionVisitor& v) {
  v.Group("map");
  v.Add(weighting,
        Option("weighting", "weight of a point in the map; confidence is less off the centre")
            .OneOf({"confidence", "uniform"})
            .Flag());
  v.Add(merge_distance_m,
        Option("merge_distance_m", "points merge with surfels at most this far along the normal")
            .Positive()
            .Flag());
  v.Add(merge_angle_rad,
        Option("merge_angle_rad", "points merge with surfels whose normal differs by at most this")
            .Positive()
            .Below(M_PI / 2)
            .Flag());
  v.Add(max_spacing_m,
        Option("max_spacing_m", "points merge with surfels at most this far across the surface")
            .Positive()
            .Flag());
  v.Add(duplicate_share,
        Option("duplicate_share",
               "of two surfels closer than this share of their radii, and of max_spacing_m, the "
               "less confident one is removed")
            .Zero("none")
            .Flag());
  v.Add(max_slant_scale,
        Option("max_slant_scale", "the radius grows by this factor at most on slanted surfaces")
            .AtLeast(1));
  v.Add(max_radius_ratio,
        Option("max_radius_ratio", "points that are coarser by this factor do not move a surfel")
            .Positive());
  v.Add(lasting_confidence,
        Option("lasting_confidence", "surfels of less confidence are removed when dormant")
            .AtLeast(0)
            .Flag());
  v.Add(max_dormant_frames,
        Option("max_dormant_frames",
               "surfels not seen in more fused frames are dormant for lasting_confidence")
            .AtLeast(0)
            .Flag());
  v.Add(max_confidence,
        Option("max_confidence", "confidence is limited so that the map can still change")
            .Positive());
  v.Add(active_frames,
        Option("active_frames",
               "surfels not seen in this many fused frames are neither tracked against nor fused "
               "with; with loop_closure what loops need")
            .Zero("no limit")
            .Flag());
  v.Add(max_map_points,
        Option("max_map_points", "surfels in the map at most; those refused are counted")
            .Zero("no limit")
            .Flag());
  v.Add(free_space_margin_m,
        Option("free_space_margin_m",
               "surfels are removed where depth is measured farther behind them, plus 4 sigma")
            .Positive()
            .Flag());
}

void RenderOptions::Visit(OptionVisitor& v) {
  v.Add(stable_confidence,
        Option("stable_confidence", "surfels of less confidence are drawn only where no others are")
            .AtLeast(0));
  v.Add(radius_share,
        Option("radius_share", "a disc covers pixels within this share of its radius").Positive());
  v.Add(
      max_half_window_px,
      Option("max_half_window_px", "half the window of pixels that a disc may cover").From(0, 64));
  v.Add(surface_thickness_m,
        Option("surface_thickness_m",
               "discs this far behind the first one, plus 4 sigma, are the same surface")
            .AtLeast(0));
}

}  // namespace surfit
