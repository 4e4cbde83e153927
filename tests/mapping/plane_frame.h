#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "mapping/same_map.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/fusion.h"
#include "testing/pixels.h"

namespace surfit::testing {

struct FrameWithSurface {
  RgbdFrame frame;
  FrameLevel surface;
};

inline void SetPixel(int u, int v, double depth_m, const Eigen::Vector3d& normal_in_camera,
                     FrameWithSurface* f) {
  f->frame.depth_m(u, v) = static_cast<float>(depth_m);
  f->surface.vertex.Set(u, v, (depth_m * f->surface.camera.Ray(u, v)).cast<float>());
  f->surface.normal.Set(u, v, normal_in_camera.cast<float>());
}

inline FrameWithSurface BlankFrame(const PinholeCamera& camera, int index) {
  const int width = camera.width, height = camera.height;
  FrameWithSurface f;
  f.frame.index = index;
  f.frame.depth_m = Image<float>(width, height, 0.f);
  f.frame.color = Image<Rgb8>(width, height, Rgb8{100, 150, 200});
  f.surface = {camera, {}, VectorImage(width, height), VectorImage(width, height), {}};
  return f;
}

// Frame of the world plane z = depth_m. All rays must intersect the plane from its -z side.
inline FrameWithSurface WallFrame(const PinholeCamera& camera, const Rigid3d& world_from_camera,
                                  double depth_m, int index) {
  FrameWithSurface f = BlankFrame(camera, index);
  const Eigen::Vector3d normal = world_from_camera.rotation.conjugate() * Eigen::Vector3d(0, 0, -1);
  const double distance = depth_m - world_from_camera.translation.z();
  for (const auto [u, v] : PixelsOf(camera)) {
    SetPixel(u, v, -distance / normal.dot(camera.Ray(u, v)), normal, &f);
  }
  return f;
}

inline PinholeCamera TestCamera() { return {64, 48, 80, 80, 31.5, 23.5, {}}; }

// Fuses a frame and checks that the numbers of the report are consistent.
inline FusionReport Fuse(const FrameWithSurface& f, const Rigid3d& pose, Fusion* fusion,
                         SurfelMap* map) {
  const int before = static_cast<int>(map->size());
  const FusionReport report = fusion->Fuse(f.frame, f.surface, pose, map);
  ExpectConsistent(*map);
  EXPECT_EQ(static_cast<int>(map->size()), before + report.added - report.removed);
  EXPECT_GE(report.covered_points, 0);
  EXPECT_EQ(report.merged_points + report.covered_points + report.added + report.refused,
            report.input_points);
  EXPECT_LE(report.merged, report.merged_points);
  return report;
}

inline std::vector<float> Confidences(const SurfelMap& map) {
  std::vector<float> confidences;
  for (const std::int32_t id : map.Ids()) confidences.push_back(map[id].confidence);
  return confidences;
}

}  // namespace surfit::testing
