#pragma once

#include <cstddef>
#include <cstdint>
#include <iomanip>
#include <sstream>
#include <string>

#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// The 64-bit FNV-1a hash (Fowler, Noll, Vo).
class Fnv1a {
 public:
  void Add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) {
      hash_ = (hash_ ^ bytes[i]) * 1099511628211u;  // NOLINT: the bytes are set
    }
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037u;
};

// The hash of a trajectory's and a map's bytes, in hexadecimal.
inline std::string Digest(const Trajectory& trajectory, const SurfelMap& map) {
  Fnv1a hash;
  for (const StampedPose& pose : trajectory) {
    hash.Add(&pose.stamp_s, sizeof(double));
    hash.Add(pose.world_from_camera.translation.data(), 3 * sizeof(double));
    hash.Add(pose.world_from_camera.rotation.coeffs().data(), 4 * sizeof(double));
  }
  for (const std::int32_t id : map.Ids()) {
    const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
    const int k = id % SurfelBlock::kCapacity;
    const float numbers[] = {block.x[k], block.y[k], block.z[k], block.confidence[k]};
    const std::int16_t normal[] = {block.nx[k], block.ny[k], block.nz[k]};
    const std::uint16_t shorts[] = {block.radius[k], block.red[k], block.green[k], block.blue[k]};
    const std::int32_t frames[] = {block.first_seen[k], block.last_seen[k]};
    hash.Add(numbers, sizeof(numbers));
    hash.Add(normal, sizeof(normal));
    hash.Add(shorts, sizeof(shorts));
    hash.Add(frames, sizeof(frames));
  }
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash.hash();
  return text.str();
}

}  // namespace surfit
