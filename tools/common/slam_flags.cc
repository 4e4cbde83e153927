#include "common/slam_flags.h"

#include <gflags/gflags.h>

namespace {

const surfit::PreprocessOptions kPreprocess;
const surfit::IcpOptions kIcp;

}  // namespace

DEFINE_double(min_coarse_step_px, kIcp.min_coarse_step_px,
              "a coarser level also ends where points move by less, px of the level");
DEFINE_double(max_free_space_share, kIcp.max_free_space_share,
              "a larger share of points in space that the other view saw through is a failure; 1 = "
              "off");
DEFINE_double(photometric_weight, kIcp.error_model.photometric_weight,
              "weight of the difference of intensities beside that of surfaces; 0 = surfaces only");
DEFINE_double(intensity_sigma, kIcp.error_model.intensity_sigma,
              "standard deviation of that difference, of intensities from 0 to 1");
DEFINE_int32(depth_filter_radius, kPreprocess.filter_radius_px,
             "half the window of the depth filter, px; 0 = no filter");
DEFINE_int32(normal_radius, kPreprocess.normal_radius_px,
             "normals come from depths up to this far apart, px");
DEFINE_int32(pyramid_levels, kPreprocess.pyramid_levels,
             "resolutions to register on, as far as the image allows");

namespace surfit::tools {

PreprocessOptions PreprocessOptionsFromFlags() {
  PreprocessOptions options;
  options.noise = IcpOptionsFromFlags({}).error_model.noise;
  options.filter_radius_px = FLAGS_depth_filter_radius;
  options.normal_radius_px = FLAGS_normal_radius;
  options.pyramid_levels = FLAGS_pyramid_levels;
  return options;
}

IcpOptions FrameIcpOptionsFromFlags(const IcpOptions& base) {
  IcpOptions options = IcpOptionsFromFlags(base);
  options.min_coarse_step_px = FLAGS_min_coarse_step_px;
  options.error_model.photometric_weight = FLAGS_photometric_weight;
  options.error_model.intensity_sigma = FLAGS_intensity_sigma;
  options.max_free_space_share = FLAGS_max_free_space_share;
  return options;
}

}  // namespace surfit::tools
