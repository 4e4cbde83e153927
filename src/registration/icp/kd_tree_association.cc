#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/kd_tree.h"
#include "surfit/core/error.h"
#include "surfit/registration/association.h"

namespace surfit {
namespace {

constexpr int kPointsPerBlock = 512;

}  // namespace

// Search tree. Normals and information (1 / variance) are in the order of the tree points.
struct SearchablePoints::Data {
  explicit Data(const PointSet& set) : tree(set.points) {
    normals.reserve(set.size());
    information.reserve(set.size());
    for (const std::uint32_t i : tree.order()) {
      normals.push_back(set.normals[i]);
      information.push_back(1 / (set.sigma_m[i] * set.sigma_m[i]));
    }
  }

  KdTree tree;
  std::vector<Eigen::Vector3f> normals;
  std::vector<float> information;
};

SearchablePoints::SearchablePoints(const PointSet& points) {
  ThrowIf(points.normals.size() != points.size() || points.sigma_m.size() != points.size(),
          "the point set has ", points.size(), " points, ", points.normals.size(), " normals and ",
          points.sigma_m.size(), " standard deviations, must have one of each per point");
  data_ = std::make_shared<const Data>(points);
}

int SearchablePoints::size() const { return static_cast<int>(data_->tree.size()); }

// Match of each source point in the previous search, used as a search hint. A wrong hint only costs
// time. The values are atomic, because several finders can run at the same time.
struct KdTreeAssociation::LastMatches {
  explicit LastMatches(int count) : ranks(count) {
    for (auto& rank : ranks) rank.store(KdTree::kNone, std::memory_order_relaxed);
  }
  std::vector<std::atomic<std::uint32_t>> ranks;
};

class KdTreeAssociation::Finder final : public PairFinder {
 public:
  Finder(const KdTreeAssociation& association, const Rigid3d& target_from_source)
      : source_(*association.source_.data_),
        target_(*association.target_.data_),
        options_(association.options_),
        last_matches_(association.last_matches_->ranks),
        rotation_(target_from_source.rotation.toRotationMatrix().cast<float>()),
        translation_(target_from_source.translation.cast<float>()) {
    const AssociationGates& gates = options_.gates;
    const bool gated = gates.max_normal_angle_rad > 0;
    if (gates.max_distance_m > 0) {
      max_distance2_ = static_cast<float>(gates.max_distance_m * gates.max_distance_m);
    }
    if (gated) min_cosine_ = static_cast<float>(std::cos(gates.max_normal_angle_rad));
    target_normal_ = gated || options_.needed_normals != NeededNormals::kNone;
    source_normal_ = gated || options_.needed_normals == NeededNormals::kBoth;
  }

  int Find(int block, int first, PairBuffer* pairs) const override {
    int next = first;
    const int begin = block * kPointsPerBlock;
    const int end = std::min(begin + kPointsPerBlock, static_cast<int>(last_matches_.size()));
    std::uint32_t neighbor = KdTree::kNone;  // match of the previous source point
    for (int i = begin; i < end; ++i) {
      const std::uint32_t rank = static_cast<std::uint32_t>(i) * options_.source_stride;
      if (source_normal_ && source_.normals[rank].isZero(0.f)) continue;
      const Eigen::Vector3f p = rotation_ * source_.tree.Point(rank) + translation_;
      const std::uint32_t last = last_matches_[i].load(std::memory_order_relaxed);
      const std::uint32_t match =
          target_.tree.Nearest(p, max_distance2_, last != KdTree::kNone ? last : neighbor).rank;
      last_matches_[i].store(match, std::memory_order_relaxed);
      if (match == KdTree::kNone) continue;
      neighbor = match;
      const Eigen::Vector3f& n = target_.normals[match];
      const Eigen::Vector3f m = rotation_ * source_.normals[rank];
      if ((target_normal_ && n.isZero(0.f)) || m.dot(n) < min_cosine_) continue;
      if (options_.reciprocal && !IsReciprocal(rank, match)) continue;
      pairs->Set(next++, p, target_.tree.Point(match), n, m, source_.information[rank]);
    }
    return next - first;
  }

 private:
  bool IsReciprocal(std::uint32_t rank, std::uint32_t match) const {
    const Eigen::Vector3f q_in_source =
        rotation_.transpose() * (target_.tree.Point(match) - translation_);
    return source_.tree.Nearest(q_in_source, KdTree::kAnyDistance, rank).rank == rank;
  }

  const SearchablePoints::Data& source_;
  const SearchablePoints::Data& target_;
  const KdTreeAssociationOptions& options_;
  std::vector<std::atomic<std::uint32_t>>& last_matches_;
  const Eigen::Matrix3f rotation_;
  const Eigen::Vector3f translation_;
  float max_distance2_ = KdTree::kAnyDistance;
  float min_cosine_ = -std::numeric_limits<float>::infinity();
  bool source_normal_ = false, target_normal_ = false;
};

KdTreeAssociation::KdTreeAssociation(SearchablePoints source, SearchablePoints target,
                                     const KdTreeAssociationOptions& options)
    : source_(std::move(source)), target_(std::move(target)), options_(options) {
  ThrowIf(options.source_stride < 1, "source_stride is ", options.source_stride,
          ", must be at least 1");
  const int count = (source_.size() + options.source_stride - 1) / options.source_stride;
  last_matches_ = std::make_unique<LastMatches>(count);
}

KdTreeAssociation::~KdTreeAssociation() = default;

int KdTreeAssociation::source_count() const {
  return static_cast<int>(last_matches_->ranks.size());
}

int KdTreeAssociation::block_count() const {
  return (source_count() + kPointsPerBlock - 1) / kPointsPerBlock;
}

int KdTreeAssociation::block_capacity() const { return kPointsPerBlock; }

std::unique_ptr<const PairFinder> KdTreeAssociation::At(const Rigid3d& target_from_source) const {
  return std::make_unique<Finder>(*this, target_from_source);
}

}  // namespace surfit
