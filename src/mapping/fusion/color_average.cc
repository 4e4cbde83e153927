#include "mapping/fusion/color_average.h"

#include <algorithm>
#include <cstdint>

#include "mapping/map/view_frustum.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr float kHiddenBehind = 1.05f;

enum class Missing { kIsPassedOver, kHides };

class OcclusionTest {
 public:
  OcclusionTest(const DepthPicture& picture, Missing missing)
      : nearest_m_(picture.depth_m.width(), picture.depth_m.height()), camera_(picture.camera) {
    const Image<float>& depth = picture.depth_m;
    ParallelFor(0, depth.height(), kRowsPerBlock, [&](int begin, int end) {
      for (int v = begin; v < end; ++v) {
        for (int u = 0; u < depth.width(); ++u) {
          nearest_m_(u, v) = NearestAround(depth, u, v, missing);
        }
      }
    });
  }

  bool Hides(const Eigen::Vector3f& point_in_world) const {
    const Eigen::Vector3f p = camera_.rotation * point_in_world + camera_.translation;
    if (!(p.z() > kMinDepth)) return true;
    const float u = camera_.fx * p.x() / p.z() + camera_.cx + 0.5f;
    const float v = camera_.fy * p.y() / p.z() + camera_.cy + 0.5f;
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(nearest_m_.width()) &&
          v < static_cast<float>(nearest_m_.height()))) {
      return true;
    }
    const float nearest_m = nearest_m_(static_cast<int>(u), static_cast<int>(v));
    return !(nearest_m > 0) || p.z() > kHiddenBehind * nearest_m;
  }

 private:
  // Smallest positive depth of the 3 x 3 neighbourhood. 0: there is no depth, or pixel (u, v) has
  // no depth and `missing` is kHides.
  static float NearestAround(const Image<float>& depth, int u, int v, Missing missing) {
    if (missing == Missing::kHides && !(depth(u, v) > 0)) return 0;
    float nearest = 0;
    for (int y = std::max(0, v - 1); y <= std::min(depth.height() - 1, v + 1); ++y) {
      for (int x = std::max(0, u - 1); x <= std::min(depth.width() - 1, u + 1); ++x) {
        const float z = depth(x, y);
        if (z > 0 && (nearest == 0 || z < nearest)) nearest = z;
      }
    }
    return nearest;
  }

  Image<float> nearest_m_;
  const PosedCamera& camera_;
};

}  // namespace

ColorAverage::ColorAverage(const SurfelMap& map) : map_(map), sums_(map.id_end()) {}

void ColorAverage::Add(const FrameColors& colors, const PosedCamera& camera,
                       const DepthPicture& drawn, const DepthPicture& measured) {
  const OcclusionTest by_map(drawn, Missing::kIsPassedOver), by_frame(measured, Missing::kHides);
  const std::vector<std::int32_t> cells = VisibleCells(map_, ViewFrustum(camera, 0));
  ParallelFor(0, static_cast<int>(cells.size()), 1, [&](int i, int) {
    for (const std::int32_t b : map_.cell(cells[i]).blocks) {
      const SurfelBlock& block = map_.block(b);
      ColorBatch seen;
      int places[SurfelBlock::kCapacity];
      for (int k = 0; k < block.count; ++k) {
        const Eigen::Vector3f in_world = block.Position(k);
        const Eigen::Vector3f point = camera.rotation * in_world + camera.translation;
        const Eigen::Vector3f normal = camera.rotation * block.Normal(k);
        if (!(point.z() > kMinDepth) || !(normal.dot(point) < 0)) continue;
        if (by_map.Hides(in_world) || by_frame.Hides(in_world)) continue;
        places[seen.count] = k;
        seen.Add(point, normal);
      }
      colors.LookUp(&seen);
      for (int j = 0; j < seen.count; ++j) {
        const SeenColor of_surfel = seen.Seen(j);
        Sum& sum = sums_[b * SurfelBlock::kCapacity + places[j]];
        sum.color += of_surfel.weight * of_surfel.color;
        sum.weight += of_surfel.weight;
      }
    }
  });
}

void ColorAverage::WriteTo(SurfelMap* map) const {
  for (const std::int32_t id : map->Ids()) {
    const Sum& sum = sums_[id];
    if (!(sum.weight > 0)) continue;
    map->block(id / SurfelBlock::kCapacity)
        .SetColor(id % SurfelBlock::kCapacity, sum.color / sum.weight, sum.weight);
  }
}

}  // namespace surfit
