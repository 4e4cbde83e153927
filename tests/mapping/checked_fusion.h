#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "mapping/plane_frame.h"
#include "mapping/same_map.h"
#include "surfit/mapping/fusion.h"

namespace surfit::testing {

inline PinholeCamera TestCamera() { return {64, 48, 80, 80, 31.5, 23.5, {}}; }

// Fuses a frame, and checks that the report adds up.
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
