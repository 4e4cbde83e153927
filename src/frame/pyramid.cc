#include <algorithm>
#include <cmath>
#include <utility>

#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

constexpr int kMinWidth = 40;
constexpr int kMinHeight = 30;

struct BlockMean {
  float depth_m = 0;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
};

// The mean of a 2 x 2 block over the pixels that belong to its nearest surface.
BlockMean MeanOfBlock(const FrameLevel& fine, int u, int v, float slant, float noise) {
  float nearest = 0;  // as inverse depth
  for (int i = 0; i < 4; ++i) {
    const float z = fine.vertex.z(u + (i & 1), v + (i >> 1));
    if (z > 0) nearest = std::max(nearest, 1.f / z);
  }
  if (nearest == 0) return {};
  const float bound = nearest - (noise + slant * nearest);
  BlockMean mean;
  float sum = 0, count = 0;
  for (int i = 0; i < 4; ++i) {
    const int ui = u + (i & 1), vi = v + (i >> 1);
    const float z = fine.vertex.z(ui, vi);
    if (!(z > 0) || 1.f / z < bound) continue;
    sum += 1.f / z;
    count += 1;
    mean.normal += fine.normal(ui, vi);
  }
  mean.depth_m = count / sum;
  const float norm = mean.normal.norm();
  if (norm > 0) mean.normal /= norm;
  return mean;
}

}  // namespace

FrameLevel HalfResolution(const FrameLevel& fine, const PreprocessOptions& options) {
  FrameLevel coarse;
  coarse.camera = fine.camera.Binned(2);
  const int width = coarse.camera.width, height = coarse.camera.height;
  coarse.normal.Resize(width, height);
  Image<float> depth(width, height);
  const float slant = static_cast<float>(std::tan(options.max_slant_rad) / fine.camera.fx);
  const float noise = static_cast<float>(3 * options.noise.inverse_depth_sigma);
  ParallelFor(0, height, 16, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) {
        const BlockMean mean = MeanOfBlock(fine, 2 * u, 2 * v, slant, noise);
        depth(u, v) = mean.depth_m;
        coarse.normal.Set(u, v, mean.normal);
      }
    }
  });
  coarse.vertex = VertexMap(depth, coarse.camera);
  return coarse;
}

FramePyramid BuildPyramid(FrameLevel finest, const PreprocessOptions& options) {
  FramePyramid pyramid;
  pyramid.levels.push_back(std::move(finest));
  while (static_cast<int>(pyramid.levels.size()) < options.pyramid_levels &&
         pyramid.levels.back().camera.width / 2 >= kMinWidth &&
         pyramid.levels.back().camera.height / 2 >= kMinHeight) {
    pyramid.levels.push_back(HalfResolution(pyramid.levels.back(), options));
  }
  return pyramid;
}

FramePyramid PreprocessDepth(const Image<float>& depth_m, const PinholeCamera& camera,
                             const PreprocessOptions& options) {
  FrameLevel finest;
  finest.camera = camera;
  finest.vertex = VertexMap(FilterDepth(depth_m, options), camera);
  finest.normal = NormalMap(finest.vertex, camera, options);
  return BuildPyramid(std::move(finest), options);
}

}  // namespace surfit
