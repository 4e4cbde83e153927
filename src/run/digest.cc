#include "run/digest.h"

#include <iomanip>
#include <sstream>

namespace surfit {
namespace {

class Fnv1a {
 public:
  void Add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash_ = (hash_ ^ bytes[i]) * 1099511628211u;
  }
  template <typename T>
  void AddArray(const std::vector<T>& array) {
    Add(array.data(), array.size() * sizeof(T));
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037u;
};

}  // namespace

std::string Digest(const Trajectory& trajectory, const SurfelMap& map) {
  Fnv1a hash;
  for (const StampedPose& pose : trajectory) {
    hash.Add(&pose.stamp_s, sizeof(double));
    hash.Add(pose.world_from_camera.translation.data(), 3 * sizeof(double));
    hash.Add(pose.world_from_camera.rotation.coeffs().data(), 4 * sizeof(double));
  }
  for (const auto* array :
       {&map.x, &map.y, &map.z, &map.nx, &map.ny, &map.nz, &map.radius_m, &map.confidence}) {
    hash.AddArray(*array);
  }
  for (const auto* array : {&map.red, &map.green, &map.blue}) hash.AddArray(*array);
  for (const auto* array : {&map.first_seen, &map.last_seen}) hash.AddArray(*array);
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash.hash();
  return text.str();
}

}  // namespace surfit
