#include <cmath>

#include "apps/live/live_run.h"
#include "core/median.h"

namespace surfit {
namespace {

struct DepthStatistics {
  double valid_ratio = 0;
  double median_m = 0;  // 0: no valid pixel
};

DepthStatistics LookAtDepth(const Image<float>& depth_m) {
  constexpr int kStep = 8;
  std::vector<float> depths;
  int pixels = 0;
  for (int v = 0; v < depth_m.height(); v += kStep) {
    for (int u = 0; u < depth_m.width(); u += kStep) {
      ++pixels;
      if (depth_m(u, v) > 0) depths.push_back(depth_m(u, v));
    }
  }
  if (depths.empty()) return {};
  return {static_cast<double>(depths.size()) / pixels, MedianOf(depths)};
}

double ImageShift(const Rigid3d& before, const Rigid3d& now, const PinholeCamera& camera,
                  double depth_m) {
  const Rigid3d moved = before.Inverse() * now;
  const double turn_rad = 2 * std::atan2(moved.rotation.vec().norm(), std::abs(moved.rotation.w()));
  return camera.fx / camera.width * (turn_rad + moved.translation.norm() / depth_m);
}

}  // namespace

std::vector<Advice> Advise(const SlamRunFrame& frame, const Rigid3d* world_from_camera_before) {
  // Maximum image motion per frame, relative to the image width. Half of the default of
  // max_view_shift. Registration is unreliable above max_view_shift.
  constexpr double kFast = 0.05;
  constexpr double kClose_m = 0.45;     // minimum distance of most sensors
  constexpr double kLittleDepth = 0.3;  // minimum ratio of pixels with depth
  constexpr double kMuchMotion = 0.1;   // maximum ratio of moving points
  const FrameReport& report = frame.report;
  const DepthStatistics depth = LookAtDepth(frame.frame.depth_m);
  std::vector<Advice> all;
  if (!report.HasPose()) {
    all.push_back({"lost", "Lost: go back to the last tracked view"});
  } else if (world_from_camera_before && depth.median_m > 0 &&
             ImageShift(*world_from_camera_before, report.world_from_camera, frame.sensor.camera,
                        depth.median_m) > kFast) {
    all.push_back({"too_fast", "Too fast: move and turn more slowly"});
  }
  if (depth.median_m > 0 && depth.median_m < kClose_m) {
    all.push_back({"too_close", "Too close: step back"});
  } else if (depth.valid_ratio < kLittleDepth) {
    all.push_back({"little_depth", "Little depth: surfaces are too close, too far or too shiny"});
  }
  if (report.state == FrameState::kDegenerate) {
    all.push_back({"little_shape", "Little structure: keep corners or furniture in view"});
  }
  if (report.has_two_motions || report.moving_ratio > kMuchMotion) {
    all.push_back({"moving", "Moving objects: keep them out of view"});
  }
  return all;
}

}  // namespace surfit
