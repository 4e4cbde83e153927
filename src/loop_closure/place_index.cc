#include "surfit/loop_closure/place_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {

namespace {

constexpr int kDescriptorBits = 256;
constexpr int kHashBits = 14;
constexpr int kMaxHamming = 48;  // of matching descriptors

std::vector<int> ChooseBits(int count, std::mt19937_64* generator) {
  std::vector<int> bits(kDescriptorBits);
  std::iota(bits.begin(), bits.end(), 0);
  for (int i = 0; i < count; ++i) {
    std::swap(bits[i], bits[i + static_cast<int>((*generator)() % (kDescriptorBits - i))]);
  }
  bits.resize(count);
  return bits;
}

}  // namespace

PlaceIndex::PlaceIndex(const PlaceIndexOptions& options) : options_(options) {
  Validate(options);
  std::mt19937_64 generator(1);
  for (int table = 0; table < kTables; ++table) {
    chosen_bits_.push_back(ChooseBits(kHashBits, &generator));
  }
  buckets_.resize(std::size_t{kTables} << kHashBits);
}

std::uint32_t PlaceIndex::HashOf(const BinaryDescriptor& descriptor, int table) const {
  std::uint32_t hash = table;
  for (const int bit : chosen_bits_[table]) {
    hash = 2 * hash + ((descriptor[bit / 64] >> (bit % 64)) & 1);
  }
  return hash;
}

void PlaceIndex::Insert(const Entry& entry) {
  const auto index = static_cast<std::uint32_t>(entries_.size());
  for (int table = 0; table < kTables; ++table) {
    buckets_[HashOf(entry.descriptor, table)].push_back(index);
  }
  entries_.push_back(entry);
}

void PlaceIndex::Add(int keyframe, const PlaceView& view) {
  ThrowIf(keyframes_.count(keyframe) > 0, "keyframe ", keyframe, " is in the index already");
  const std::size_t begin = entries_.size();
  for (const PlaceFeature& feature : view.features) Insert({feature.descriptor, keyframe});
  keyframes_[keyframe] = {begin, entries_.size()};
}

void PlaceIndex::Remove(int keyframe) {
  const auto removed = keyframes_.find(keyframe);
  if (removed == keyframes_.end()) return;
  const EntryRange range = removed->second;
  keyframes_.erase(removed);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    for (int table = 0; table < kTables; ++table) {
      std::vector<std::uint32_t>& bucket = buckets_[HashOf(entries_[i].descriptor, table)];
      bucket.erase(std::lower_bound(bucket.begin(), bucket.end(), i));
    }
  }
  unused_ += range.end - range.begin;
  if (unused_ > entries_.size() / 2) Compact();
}

// Removes unused entries. Indices of entries change.
void PlaceIndex::Compact() {
  const std::vector<Entry> all = std::exchange(entries_, {});
  for (std::vector<std::uint32_t>& bucket : buckets_) bucket.clear();
  unused_ = 0;
  std::vector<std::pair<EntryRange, int>> kept;
  for (const auto& [keyframe, range] : keyframes_) kept.emplace_back(range, keyframe);
  std::sort(kept.begin(), kept.end(),
            [](const auto& a, const auto& b) { return a.first.begin < b.first.begin; });
  for (const auto& [range, keyframe] : kept) {
    const std::size_t begin = entries_.size();
    for (std::size_t i = range.begin; i < range.end; ++i) Insert(all[i]);
    keyframes_[keyframe] = {begin, entries_.size()};
  }
}

std::vector<PlaceCandidate> PlaceIndex::Query(
    const PlaceView& view, int max_count,
    const std::function<bool(int keyframe)>& is_wanted) const {
  std::map<int, double> votes;
  double all_votes = 0;
  std::vector<int> found;
  for (const PlaceFeature& feature : view.features) {
    found.clear();
    for (int table = 0; table < kTables; ++table) {
      for (const std::uint32_t index : buckets_[HashOf(feature.descriptor, table)]) {
        const Entry& entry = entries_[index];
        if (Hamming(entry.descriptor, feature.descriptor) <= kMaxHamming) {
          found.push_back(entry.keyframe);
        }
      }
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    const double weight = std::log((1. + keyframe_count()) / std::max<double>(1, found.size()));
    all_votes += weight;
    for (const int keyframe : found) votes[keyframe] += weight;
  }
  std::vector<PlaceCandidate> candidates;
  for (const auto& [keyframe, vote] : votes) {
    const double similarity = all_votes > 0 ? vote / all_votes : 0;
    if (similarity >= options_.min_similarity && is_wanted(keyframe)) {
      candidates.push_back({keyframe, similarity});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.similarity > b.similarity; });
  if (static_cast<int>(candidates.size()) > max_count) candidates.resize(max_count);
  return candidates;
}

std::size_t PlaceIndex::Bytes() const {
  return (entries_.size() - unused_) * (sizeof(Entry) + kTables * sizeof(std::uint32_t));
}

namespace {

// Difference of two poses, m: translation plus 2 m times the rotation angle.
double Difference(const Keyframe& a, const Keyframe& b) {
  constexpr double kDistanceM = 2;
  const Rigid3d motion = a.world_from_camera.Inverse() * b.world_from_camera;
  return motion.translation.norm() + kDistanceM * RotationAngle(motion.rotation);
}

std::vector<int> WithViews(const std::vector<Keyframe>& keyframes) {
  std::vector<int> positions;
  for (int i = 0; i < static_cast<int>(keyframes.size()); ++i) {
    if (!keyframes[i].view.empty()) positions.push_back(i);
  }
  return positions;
}

// Pose of a keyframe with a view.
struct ViewPose {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  int position = 0;
};

// Lower bound of Difference(), except for rounding: the angle is at least 2 sin(angle / 2).
double LeastDifference(const ViewPose& a, const ViewPose& b) {
  const double cosine = a.rotation.coeffs().dot(b.rotation.coeffs());
  return (a.translation - b.translation).norm() + 4 * std::sqrt(std::max(0., 1 - cosine * cosine));
}

// Returns the older keyframe of the most similar pair, or the only keyframe. If pairs are
// equal, the pair with the older keyframes wins. Keyframes are sorted along one axis, so that only
// pairs are compared whose distance along this axis is smaller than the least difference. The
// search starts with successive keyframes, which are similar.
int MostRedundant(const std::vector<Keyframe>& keyframes, const std::vector<int>& positions) {
  // The inverse of a pose is rounded, so its distance can be slightly smaller. The square root has
  // half of the digits.
  constexpr double kMargin = 1e-6;
  std::pair<int, int> least = {positions.front(), positions.front()};
  double least_difference = std::numeric_limits<double>::infinity();
  const auto compare = [&](int a, int b) {
    const auto pair = std::minmax(a, b);
    const double difference = Difference(keyframes[pair.first], keyframes[pair.second]);
    if (std::pair(difference, std::pair<int, int>(pair)) >= std::pair(least_difference, least))
      return;
    least_difference = difference;
    least = pair;
  };
  for (std::size_t i = 1; i < positions.size(); ++i) compare(positions[i - 1], positions[i]);
  std::vector<ViewPose> poses;
  poses.reserve(positions.size());
  for (const int position : positions) {
    const Rigid3d& pose = keyframes[position].world_from_camera;
    poses.push_back({pose.translation, pose.rotation.normalized(), position});
  }
  std::sort(poses.begin(), poses.end(), [](const ViewPose& a, const ViewPose& b) {
    return a.translation.x() < b.translation.x();
  });
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double margin = kMargin * (1 + poses[i].translation.norm());
    for (std::size_t j = i + 1; j < poses.size(); ++j) {
      const double apart = poses[j].translation.x() - poses[i].translation.x();
      if (apart > least_difference + margin) break;
      if (LeastDifference(poses[i], poses[j]) <= least_difference + margin)
        compare(poses[i].position, poses[j].position);
    }
  }
  return least.first;
}

}  // namespace

std::vector<int> LimitKeyframes(std::size_t max_bytes, std::vector<Keyframe>* keyframes,
                                PlaceIndex* index) {
  std::size_t bytes = 0;
  for (const Keyframe& keyframe : *keyframes) bytes += keyframe.view.Bytes();
  std::vector<int> given_up;
  while (bytes > max_bytes) {
    const int position = MostRedundant(*keyframes, WithViews(*keyframes));
    bytes -= (*keyframes)[position].view.Bytes();
    (*keyframes)[position].view = PlaceView();
    index->Remove(position);
    given_up.push_back(position);
  }
  return given_up;
}

}  // namespace surfit
