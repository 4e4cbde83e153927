// Options of the depth sensors.
#include "surfit/core/options.h"

#include "surfit/core/error.h"
#include "surfit/simulation/render.h"

namespace surfit {
namespace {

void AddDepthLimits(double* min_depth_m, double* max_depth_m, OptionVisitor* v) {
  v->Add(*min_depth_m, "min_depth_m", "smaller depth is missing", Positive());
  v->Add(*max_depth_m, "max_depth_m", "larger depth is missing", Positive());
  v->Check([=] {
    ThrowIf(!(*max_depth_m > *min_depth_m), "max_depth_m is ", *max_depth_m,
            ", must be above min_depth_m");
  });
}

void AddEdgeRatio(double* edge_ratio, OptionVisitor* v) {
  v->Add(*edge_ratio, "edge_ratio",
         "distance to the tangent plane beyond a depth edge, divided by the depth", Positive());
}

}  // namespace

void StereoOptions::Visit(OptionVisitor& v) {
  v.Add(baseline_m, "baseline_m", "distance of the two cameras", Positive());
  v.Add(matcher_focal_px, "matcher_focal_px", "focal length at the resolution of the matching",
        Positive());
  v.Add(disparity_sd_px, "disparity_sd_px",
        "standard deviation of the disparity at the resolution of the matching", AtLeast(0));
  v.Add(correlation_px, "correlation_px", "correlation length of the noise in the image",
        Between(0, 200));
  v.Add(window_px, "window_px", "radius of the matching window in the image", Between(0, 50));
  AddEdgeRatio(&edge_ratio, &v);
  v.Add(edge_loss, "edge_loss", "ratio of missing pixels with a depth edge in the window", Share());
  v.Add(projector_contrast, "projector_contrast",
        "contrast of the projected pattern on a white frontal surface at 1 m", AtLeast(0));
  v.Add(min_contrast, "min_contrast", "smaller contrast is missing", AtLeast(0));
  v.Add(min_contrast_sd, "min_contrast_sd",
        "standard deviation of the logarithm of min_contrast in the image", AtLeast(0));
  v.Add(max_incidence_deg, "max_incidence_deg", "larger angles of incidence are missing",
        Positive(), Between(0, 90));
  AddDepthLimits(&min_depth_m, &max_depth_m, &v);
}

void RangeNoise::Visit(OptionVisitor& v) {
  v.Add(floor_m, "floor_m", "standard deviation at infinite signal", AtLeast(0));
  v.Add(shot_m, "shot_m", "shot noise of a white frontal surface at 1 m without ambient light",
        AtLeast(0));
  v.Add(ambient, "ambient", "ambient light, divided by the signal of this surface", AtLeast(0));
}

void TofOptions::Visit(OptionVisitor& v) {
  v.AddPart(noise, "noise", "noise of a range");
  v.Add(multipath_gain, "multipath_gain", "factor of the indirect light from other surfaces",
        ZeroIs("no multipath"));
  v.Add(modulation_hz, "modulation_hz", "frequency of the modulated light", Positive());
  v.Add(flying_ratio, "flying_ratio", "ratio of flying pixels beside depth edges", Share());
  AddEdgeRatio(&edge_ratio, &v);
  v.Add(max_sigma_m, "max_sigma_m", "larger noise is missing", Positive());
  AddDepthLimits(&min_depth_m, &max_depth_m, &v);
}

void LidarOptions::Visit(OptionVisitor& v) {
  v.AddPart(noise, "noise", "noise of the range of a dot");
  v.Add(dots_across, "dots_across", "columns of the grid of dots", Between(2, 1000));
  v.Add(dots_down, "dots_down", "rows of the grid of dots", Between(2, 1000));
  v.Add(color_scale, "color_scale", "colour difference with the weight exp(-1/2)", Positive());
  AddEdgeRatio(&edge_ratio, &v);
  v.Add(edge_px, "edge_px", "radius of low confidence around depth edges", Between(0, 50));
  v.Add(high_sigma_m, "high_sigma_m", "largest noise of a dot for high confidence", Positive());
  v.Add(medium_sigma_m, "medium_sigma_m", "largest noise of a dot for medium confidence",
        Positive());
  v.Check([this] {
    ThrowIf(!(medium_sigma_m >= high_sigma_m), "medium_sigma_m is ", medium_sigma_m,
            ", must not be below high_sigma_m");
  });
}

}  // namespace surfit
