#include "apps/live/map_sample.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr int kRadius = 14, kConfidence = 15;  // byte positions in PackedSurfel
constexpr std::uint32_t kBlock = 256;

std::uint64_t Millimetres(float metres) {
  constexpr double kBorder = 1 << 20;
  const double shifted = std::floor(1000. * static_cast<double>(metres) + kBorder + 0.5);
  return static_cast<std::uint64_t>(std::clamp(shifted, 0., 2 * kBorder - 1));
}

std::size_t BlockCount(std::size_t slots) { return (slots + kBlock - 1) / kBlock; }

}  // namespace

PackedSurfel PackSurfel(const Surfel& surfel) {
  const Eigen::Vector3f& p = surfel.position_in_world;
  const std::uint64_t place =
      Millimetres(p.x()) | Millimetres(p.y()) << 21 | Millimetres(p.z()) << 42;
  PackedSurfel packed;
  for (int i = 0; i < 8; ++i) packed[i] = static_cast<std::uint8_t>(place >> (8 * i));
  for (int i = 0; i < 3; ++i) {
    const float n = std::clamp(std::round(127.f * surfel.normal_in_world[i]), -127.f, 127.f);
    packed[8 + i] = static_cast<std::uint8_t>(static_cast<std::int8_t>(n));
  }
  packed[11] = surfel.color.r;
  packed[12] = surfel.color.g;
  packed[13] = surfel.color.b;
  packed[kRadius] =
      static_cast<std::uint8_t>(std::clamp(std::round(2000.f * surfel.radius_m), 1.f, 255.f));
  packed[kConfidence] = WeightByte::From(surfel.confidence);
  return packed;
}

// Adds slots for new surfel ids. If there are too many slots, every second slot is dropped.
// Versions remain valid, because the web pages drop the same slots.
void MapSample::Fit(const SurfelMap& map) {
  const auto ids = static_cast<std::uint64_t>(map.id_end());
  const auto needed = [&] {
    return static_cast<std::size_t>((ids + (std::uint64_t{1} << level_) - 1) >> level_);
  };
  while (needed() > most_slots_) {
    ++level_;
    const std::size_t left = (surfels_.size() + 1) / 2;
    for (std::size_t i = 0; i < left; ++i) {
      surfels_[i] = surfels_[2 * i];
      versions_[i] = versions_[2 * i];
    }
    surfels_.resize(left);
    versions_.resize(left);
    for (std::size_t i = 0; i < newest_.size(); ++i) {
      newest_[i / 2] = std::max(i % 2 == 0 ? 0 : newest_[i / 2], newest_[i]);
    }
    newest_.resize(BlockCount(left));
    next_ /= 2;
    shown_ = static_cast<std::size_t>(
        std::count_if(surfels_.begin(), surfels_.end(),
                      [](const PackedSurfel& surfel) { return surfel[kRadius] != 0; }));
  }
  if (needed() <= surfels_.size()) return;
  surfels_.resize(needed(), PackedSurfel{});
  versions_.resize(needed(), 0);
  newest_.resize(BlockCount(needed()), 0);
}

void MapSample::Look(const SurfelMap& map, std::uint32_t slot) {
  const auto id = static_cast<std::int32_t>(std::uint64_t{slot} << level_);
  const bool is_there = id < map.id_end() && map.Has(id);
  const PackedSurfel now = is_there ? PackSurfel(map[id]) : PackedSurfel{};
  PackedSurfel& before = surfels_[slot];
  if (now == before) return;
  shown_ += (now[kRadius] != 0 ? 1 : 0);
  shown_ -= (before[kRadius] != 0 ? 1 : 0);
  before = now;
  versions_[slot] = newest_[slot / kBlock] = version_;
}

bool MapSample::Update(const SurfelMap& map, std::size_t slots) {
  Fit(map);
  ++version_;
  const std::size_t end = std::min(surfels_.size(), next_ + slots);
  while (next_ < end) Look(map, next_++);
  if (next_ < surfels_.size()) return false;
  next_ = 0;
  return true;
}

void MapSample::Reset(const SurfelMap& map) {
  ++epoch_;
  level_ = next_ = 0;
  shown_ = 0;
  surfels_.clear();
  versions_.clear();
  newest_.clear();
  Update(map, most_slots_);
}

SampleChanges MapSample::ChangesFrom(SamplePlace place, std::size_t most) const {
  if (place.epoch != epoch_ || place.level > level_) place = {epoch_, level_, 0, 0};
  // Rounds down, so one slot may be sent again.
  while (place.level < level_) {
    ++place.level;
    place.slot /= 2;
  }
  SampleChanges changes;
  changes.epoch = epoch_;
  changes.level = level_;
  changes.slots = static_cast<std::uint32_t>(surfels_.size());
  changes.version = version_;
  for (std::uint32_t slot = place.slot; slot < changes.slots; ++slot) {
    if (newest_[slot / kBlock] <= place.version) {
      slot |= kBlock - 1;  // skips the rest of a block without changes
      continue;
    }
    if (versions_[slot] <= place.version) continue;
    if (changes.slot.size() == most) {
      changes.next = slot;
      break;
    }
    changes.slot.push_back(slot);
    changes.surfel.push_back(surfels_[slot]);
  }
  return changes;
}

std::uint8_t MapSample::Dust() const {
  std::array<std::size_t, 256> counts{};
  for (const PackedSurfel& surfel : surfels_) {
    if (surfel[kRadius] != 0) ++counts[surfel[kConfidence]];
  }
  std::size_t below = 0;
  int quantile = 0;  // 90 % quantile
  while (quantile < 255 && 10 * (below += counts[quantile]) < 9 * shown_) ++quantile;
  return WeightByte::From(
      std::min(3.f, 0.1f * WeightByte::ToFloat(static_cast<std::uint8_t>(quantile))));
}

}  // namespace surfit
