#include "registration/global/cloud_features.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

#include "geometry/kd_tree.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kKeysPerBlock = 64;
constexpr double kNormalCells = 2.5;  // neighbourhood radius for normals, in cells
constexpr std::size_t kLeastKeyNeighbors = 5;

using Cell = std::array<std::int64_t, 3>;

Eigen::Vector3f KeyNormal(const KdTree& tree, const std::vector<std::uint32_t>& found,
                          const Eigen::Vector3f& point, const Eigen::Vector3d& viewpoint) {
  if (found.size() < kLeastKeyNeighbors) return Eigen::Vector3f::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const std::uint32_t rank : found) {
    const Eigen::Vector3d offset = tree.Point(rank).cast<double>() - point.cast<double>();
    sum += offset;
    squares += offset * offset.transpose();
  }
  const double count = static_cast<double>(found.size());
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(squares / count - sum * sum.transpose() / (count * count));
  if (!(solver.eigenvalues()[1] > 1e-3 * solver.eigenvalues()[2])) return Eigen::Vector3f::Zero();
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  const double sign = normal.dot(viewpoint - point.cast<double>()) < 0 ? -1 : 1;
  return (sign * normal).cast<float>();
}

// Bins of the three angles of a pair of points with normals (Rusu et al. 2009): [0, 11), [11, 22)
// and [22, 33).
struct PairBins {
  int bins[3];
};

PairBins BinsOf(const Eigen::Vector3f& p, const Eigen::Vector3f& n, const Eigen::Vector3f& q,
                const Eigen::Vector3f& m) {
  constexpr int kBins = kFpfhBins / 3;
  const Eigen::Vector3f d = (q - p).normalized();
  const Eigen::Vector3f v = d.cross(n).normalized();
  const Eigen::Vector3f w = n.cross(v);
  const float alpha = v.dot(m), phi = n.dot(d), theta = std::atan2(w.dot(m), n.dot(m));
  const auto bin = [](float from_0_to_1) {
    return std::clamp(static_cast<int>(kBins * from_0_to_1), 0, kBins - 1);
  };
  return {{bin(0.5f * (alpha + 1)), kBins + bin(0.5f * (phi + 1)),
           2 * kBins + bin(0.5f * (theta / static_cast<float>(M_PI) + 1))}};
}

// Scales the histogram of each angle to the sum 1.
void Normalize(Fpfh* histogram) {
  constexpr int kBins = kFpfhBins / 3;
  for (int first = 0; first < kFpfhBins; first += kBins) {
    float sum = 0;
    for (int i = first; i < first + kBins; ++i) sum += (*histogram)[i];
    if (!(sum > 0)) continue;
    for (int i = first; i < first + kBins; ++i) (*histogram)[i] /= sum;
  }
}

struct NearestTwo {
  int index = -1;
  float nearest = std::numeric_limits<float>::infinity();
  float second = std::numeric_limits<float>::infinity();
};

std::vector<NearestTwo> NearestHistograms(const std::vector<Fpfh>& queries,
                                          const std::vector<Fpfh>& candidates) {
  using Histogram = Eigen::Map<const Eigen::Array<float, kFpfhBins, 1>>;
  std::vector<NearestTwo> results(queries.size());
  ParallelFor(0, static_cast<int>(queries.size()), kKeysPerBlock, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Histogram query(queries[i].data());
      if (!(query[0] >= 0) || query.isZero(0)) continue;
      NearestTwo& best = results[i];
      for (std::size_t k = 0; k < candidates.size(); ++k) {
        const float distance = (query - Histogram(candidates[k].data())).square().sum();
        if (distance < best.nearest) {
          best.second = best.nearest;
          best.nearest = distance;
          best.index = static_cast<int>(k);
        } else if (distance < best.second) {
          best.second = distance;
        }
      }
    }
  });
  return results;
}

}  // namespace

std::vector<Eigen::Vector3f> VoxelCentroids(const std::vector<Eigen::Vector3f>& points,
                                            double cell_m) {
  std::vector<std::pair<Cell, std::uint32_t>> cells(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      cells[i].first[axis] = static_cast<std::int64_t>(std::floor(points[i][axis] / cell_m));
    }
    cells[i].second = static_cast<std::uint32_t>(i);
  }
  std::sort(cells.begin(), cells.end());
  std::vector<Eigen::Vector3f> centroids;
  for (std::size_t i = 0; i < cells.size();) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const std::size_t first = i;
    for (; i < cells.size() && cells[i].first == cells[first].first; ++i) {
      sum += points[cells[i].second].cast<double>();
    }
    centroids.push_back((sum / static_cast<double>(i - first)).cast<float>());
  }
  return centroids;
}

KeyPoints MakeKeyPoints(const std::vector<Eigen::Vector3f>& points, double cell_m,
                        const Eigen::Vector3d& viewpoint) {
  KeyPoints keys;
  keys.points = VoxelCentroids(points, cell_m);
  keys.normals.assign(keys.points.size(), Eigen::Vector3f::Zero());
  const KdTree tree(keys.points);
  const auto radius2 = static_cast<float>(kNormalCells * cell_m * kNormalCells * cell_m);
  ParallelFor(0, static_cast<int>(keys.points.size()), kKeysPerBlock, [&](int begin, int end) {
    std::vector<std::uint32_t> found;
    for (int i = begin; i < end; ++i) {
      tree.FindWithin(keys.points[i], radius2, &found);
      keys.normals[i] = KeyNormal(tree, found, keys.points[i], viewpoint);
    }
  });
  return keys;
}

std::vector<Fpfh> FindFpfh(const KeyPoints& keys, double radius_m) {
  const KdTree tree(keys.points);
  const int count = static_cast<int>(keys.points.size());
  const auto radius2 = static_cast<float>(radius_m * radius_m);
  std::vector<std::vector<std::uint32_t>> neighbors(count);
  std::vector<Fpfh> simple(count, Fpfh{}), weighted(count, Fpfh{});
  ParallelFor(0, count, kKeysPerBlock, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (keys.normals[i].isZero(0)) continue;
      tree.FindWithin(keys.points[i], radius2, &neighbors[i]);
      for (std::uint32_t& rank : neighbors[i]) {
        const int k = static_cast<int>(rank = tree.order()[rank]);
        if (k == i || keys.normals[k].isZero(0)) continue;
        const PairBins pair =
            BinsOf(keys.points[i], keys.normals[i], keys.points[k], keys.normals[k]);
        for (const int bin : pair.bins) simple[i][bin] += 1;
      }
      Normalize(&simple[i]);
    }
  });
  ParallelFor(0, count, kKeysPerBlock, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      for (const std::uint32_t k : neighbors[i]) {
        const float distance = (keys.points[k] - keys.points[i]).norm();
        const float weight =
            static_cast<float>(radius_m) / std::max(distance, 1e-3f * static_cast<float>(radius_m));
        if (static_cast<int>(k) == i) continue;
        for (int bin = 0; bin < kFpfhBins; ++bin) weighted[i][bin] += weight * simple[k][bin];
      }
      Normalize(&weighted[i]);
      for (int bin = 0; bin < kFpfhBins; ++bin) weighted[i][bin] += simple[i][bin];
      Normalize(&weighted[i]);
      for (float& value : weighted[i]) value = std::sqrt(value);
    }
  });
  return weighted;
}

std::vector<KeyMatch> MatchFpfh(const std::vector<Fpfh>& source, const std::vector<Fpfh>& target,
                                int max_count) {
  const std::vector<NearestTwo> forward = NearestHistograms(source, target);
  const std::vector<NearestTwo> backward = NearestHistograms(target, source);
  std::vector<std::tuple<bool, float, int, int>> ranked;  // not mutual, ratio, source, target
  for (int i = 0; i < static_cast<int>(forward.size()); ++i) {
    const NearestTwo& nearest = forward[i];
    if (nearest.index < 0) continue;
    const bool mutual = backward[nearest.index].index == i;
    ranked.emplace_back(!mutual, nearest.second > 0 ? nearest.nearest / nearest.second : 1, i,
                        nearest.index);
  }
  std::sort(ranked.begin(), ranked.end());
  if (static_cast<int>(ranked.size()) > max_count) ranked.resize(max_count);
  std::vector<KeyMatch> matches;
  matches.reserve(ranked.size());
  for (const auto& [not_mutual, ratio, i, k] : ranked) matches.push_back({i, k});
  return matches;
}

}  // namespace surfit
