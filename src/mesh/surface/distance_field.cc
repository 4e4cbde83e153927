#include "mesh/surface/distance_field.h"

#include <algorithm>
#include <limits>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kFieldBlocksPerTask = 16;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// Index range of the grid points along one axis of a block that are inside the support of a surfel.
struct Span {
  int from, to;

  Span(float center_m, float support_m, float cell_m)
      : from(std::max(0, static_cast<int>(std::ceil((center_m - support_m) / cell_m)))),
        to(std::min(DistanceField::kSide - 1,
                    static_cast<int>(std::floor((center_m + support_m) / cell_m)))) {}
};

}  // namespace

DistanceField::DistanceField(const SurfelCubes& surfels, float cell_m,
                             const std::function<void(double)>& done)
    : cell_m_(cell_m) {
  for (const MeshSurfel& surfel : surfels.surfels())
    support_m_ = std::max(support_m_, SupportOf(surfel));
  FindBlocks(surfels);
  values_.resize(keys_.size());
  ParallelFor(0, block_count(), kFieldBlocksPerTask, [&](int begin, int end) {
    std::vector<SurfelCubes::Range> ranges;
    for (int i = begin; i < end; ++i) values_[i] = Compute(i, surfels, &ranges);
    done(static_cast<double>(end - begin) / block_count());
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (!values_[i]) continue;
    keys_[kept] = keys_[i];
    values_[kept++] = std::move(values_[i]);
  }
  keys_.resize(kept);
  values_.resize(kept);
}

void DistanceField::FindBlocks(const SurfelCubes& surfels) {
  for (int c = 0; c < surfels.cube_count(); ++c) {
    Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
    Eigen::Vector3f high = -low;
    const SurfelCubes::Range range = surfels.SurfelsOf(c);
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const MeshSurfel& surfel = surfels.surfels()[i];
      const Eigen::Vector3f margin = Eigen::Vector3f::Constant(SupportOf(surfel));
      low = low.cwiseMin(surfel.position - margin);
      high = high.cwiseMax(surfel.position + margin);
    }
    const Cube from = (low / surfels.cube_m()).array().floor().cast<int>();
    const Cube to = (high / surfels.cube_m()).array().floor().cast<int>();
    for (int z = from.z(); z <= to.z(); ++z)
      for (int y = from.y(); y <= to.y(); ++y)
        for (int x = from.x(); x <= to.x(); ++x) keys_.push_back(CubeKey::Of({x, y, z}));
  }
  std::sort(keys_.begin(), keys_.end());
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
}

std::unique_ptr<DistanceField::Values> DistanceField::Compute(
    int i, const SurfelCubes& surfels, std::vector<SurfelCubes::Range>* ranges) const {
  const Eigen::Vector3f origin = PointAt(kSide * BlockAt(i));
  const Eigen::Vector3f margin = Eigen::Vector3f::Constant(support_m_);
  const Eigen::Vector3f far_corner = origin + Eigen::Vector3f::Constant((kSide - 1) * cell_m_);
  surfels.FindWithin(origin - margin, far_corner + margin, ranges);
  Values weights = {};
  auto distances = std::make_unique<Values>();
  distances->fill(0);
  for (const SurfelCubes::Range& range : *ranges) {
    for (std::uint32_t s = range.begin; s < range.end; ++s)
      Add(surfels.surfels()[s], origin, &weights, distances.get());
  }
  bool any = false;
  for (int k = 0; k < kPoints; ++k) {
    any = any || weights[k] > 0;
    (*distances)[k] = weights[k] > 0 ? (*distances)[k] / weights[k] : kUnknown;
  }
  if (!any) distances.reset();
  return distances;
}

void DistanceField::Add(const MeshSurfel& surfel, const Eigen::Vector3f& origin, Values* weights,
                        Values* distances) const {
  const float support_m = SupportOf(surfel);
  const Eigen::Vector3f center = surfel.position - origin;
  const Span xs(center.x(), support_m, cell_m_), ys(center.y(), support_m, cell_m_),
      zs(center.z(), support_m, cell_m_);
  if (xs.from > xs.to) return;
  const SurfelKernel kernel(surfel, support_m);
  const Eigen::Vector3f& n = surfel.normal;
  for (int z = zs.from; z <= zs.to; ++z) {
    const float dz = static_cast<float>(z) * cell_m_ - center.z();
    for (int y = ys.from; y <= ys.to; ++y) {
      const float dy = static_cast<float>(y) * cell_m_ - center.y();
      const float square = dz * dz + dy * dy, height = n.z() * dz + n.y() * dy;
      if (square >= kernel.square) continue;
      float* weight = &(*weights)[(z * kSide + y) * kSide];
      float* distance = &(*distances)[(z * kSide + y) * kSide];
      for (int x = 0; x < kSide; ++x) {
        const float dx = static_cast<float>(x) * cell_m_ - center.x();
        const float w = kernel.Weight(square + dx * dx);
        weight[x] += w;
        distance[x] += w * (height + n.x() * dx);
      }
    }
  }
}

int DistanceField::FindBlock(const Cube& block) const {
  const std::uint64_t key = CubeKey::Of(block);
  const auto found = std::lower_bound(keys_.begin(), keys_.end(), key);
  return found != keys_.end() && *found == key ? static_cast<int>(found - keys_.begin()) : -1;
}

void DistanceField::Load(int i, WideBlock* values) const {
  values->fill(kUnknown);
  const Cube own = BlockAt(i);
  const auto from = [](int step) { return step < 0 ? kSide - 1 : 0; };
  const auto count = [](int step) { return step == 0 ? kSide : 1; };
  const auto to = [](int step) { return step < 0 ? 0 : step == 0 ? 1 : kSide + 1; };
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int other = FindBlock(own + Cube(dx, dy, dz));
        if (other < 0) continue;
        const Values& source = *values_[other];
        for (int z = 0; z < count(dz); ++z) {
          for (int y = 0; y < count(dy); ++y) {
            const float* row = &source[((from(dz) + z) * kSide + from(dy) + y) * kSide + from(dx)];
            std::copy_n(row, count(dx),
                        &(*values)[((to(dz) + z) * kWide + to(dy) + y) * kWide + to(dx)]);
          }
        }
      }
    }
  }
}

}  // namespace surfit
