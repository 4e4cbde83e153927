#include "io/openni/image_pairs.h"

#include <algorithm>
#include <utility>

#include "io/sequences/recording.h"

namespace surfit {
namespace {

double ApartSeconds(const DeviceImage& a, const DeviceImage& b) {
  const std::uint64_t apart_us =
      std::max(a.stamp_us, b.stamp_us) - std::min(a.stamp_us, b.stamp_us);
  return 1e-6 * static_cast<double>(apart_us);
}

}  // namespace

void ImagePairs::Add(DeviceImage image) {
  std::deque<DeviceImage>& images = image.is_depth() ? depth_ : color_;
  images.push_back(std::move(image));
  constexpr std::size_t kMost = 8;  // limits the queue if one stream stops
  if (images.size() > kMost) images.pop_front();
}

bool ImagePairs::IsDecided() const {
  constexpr std::size_t kWaiting = 3;  // depth queue length that ends the wait for colour
  if (depth_.empty()) return false;
  if (!has_color_ || depth_.size() >= kWaiting) return true;
  return !color_.empty() && color_.back().stamp_us >= depth_.front().stamp_us;
}

std::optional<ImagePair> ImagePairs::Take() {
  if (!IsDecided()) return std::nullopt;
  ImagePair pair;
  pair.depth = std::move(depth_.front());
  depth_.pop_front();
  const auto nearest = std::min_element(
      color_.begin(), color_.end(), [&](const DeviceImage& a, const DeviceImage& b) {
        return ApartSeconds(a, pair.depth) < ApartSeconds(b, pair.depth);
      });
  if (nearest == color_.end() || ApartSeconds(*nearest, pair.depth) > kMaxBetweenImages_s)
    return pair;
  pair.color = std::move(*nearest);
  color_.erase(color_.begin(), nearest + 1);
  return pair;
}

void ImagePairs::Clear() {
  depth_.clear();
  color_.clear();
}

}  // namespace surfit
