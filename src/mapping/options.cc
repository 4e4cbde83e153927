#include "surfit/core/options.h"

#include <cmath>

#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

void FusionOptions::Visit(OptionVisitor& v) {
  v.Group("map");
  v.Add(merge_distance_m, "merge_distance_m",
        "maximum distance along the normal between a surfel and a point that merge", Positive());
  v.Add(merge_angle_rad, "merge_angle_rad",
        "maximum angle between the normals of a surfel and a point that merge", Positive(),
        Below(M_PI / 2));
  v.Add(max_spacing_m, "max_spacing_m",
        "maximum distance across the surface between a surfel and a point that merge", Positive());
  v.Add(duplicate_ratio, "duplicate_ratio",
        "maximum distance of duplicate surfels, relative to their radii and to max_spacing_m; the "
        "less confident duplicate is removed",
        ZeroIs("none"));
  v.Add(max_slant_scale, "max_slant_scale",
        "maximum growth factor of the radius on slanted surfaces", AtLeast(1));
  v.Add(min_inactive_confidence, "min_inactive_confidence",
        "surfels with less confidence are removed after max_inactive_frames without observation",
        AtLeast(0));
  v.Add(max_inactive_frames, "max_inactive_frames",
        "number of fused frames without observation after which surfels below "
        "min_inactive_confidence "
        "are removed",
        AtLeast(0));
  v.Add(active_frames, "active_frames",
        "number of fused frames after which an unobserved surfel is neither tracked nor fused; "
        "loop_closure replaces 0 by its own default",
        ZeroIs("no limit"));
  v.Add(max_map_points, "max_map_points",
        "maximum number of surfels in the map; further surfels are dropped and counted",
        ZeroIs("no limit"), AsFlag());
  v.Add(free_space_margin_m, "free_space_margin_m",
        "surfels this far in front of the measured depth, plus 4 sigma, are removed", Positive());
}

void RenderOptions::Visit(OptionVisitor& v) {
  v.Add(stable_confidence, "stable_confidence",
        "surfels with less confidence are drawn only at pixels without other surfels", AtLeast(0));
  v.Add(radius_ratio, "radius_ratio", "radius of drawn discs, relative to the radius of the surfel",
        Positive());
  v.Add(max_half_window_px, "max_half_window_px", "maximum half width of a drawn disc",
        Between(0, 64));
  v.Add(surface_thickness_m, "surface_thickness_m",
        "maximum depth difference of discs that are blended, plus 4 sigma", AtLeast(0));
}

}  // namespace surfit
