#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "io/files/places_file.h"
#include "io/images/deflate.h"
#include "surfit/core/error.h"
#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/loop_closure/keyframe.h"

namespace surfit {

// Puts values one after the other, little endian, images in zlib's format.
class Packer {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void Put(const Rigid3d& pose) {
    for (const double number : pose.rotation.coeffs()) Put(number);
    for (const double number : pose.translation) Put(number);
  }
  void PutCount(std::size_t count) { Put(static_cast<std::uint32_t>(count)); }
  template <typename T>
  void PutImage(const Image<T>& image) {
    Put(image.width());
    Put(image.height());
    PutCompressed(image.data(), image.size() * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void PutCompressed(const void* data, std::size_t size) {
    const std::string compressed = Deflate(data, size, /*level=*/1);
    PutCount(compressed.size());
    bytes_ += compressed;
  }

  std::string bytes_;
};

// Takes them in the same order. Throws InputError naming where they are from.
class Unpacker {
 public:
  // `from` is for messages.
  Unpacker(std::string bytes, std::string from)
      : bytes_(std::move(bytes)), from_(std::move(from)) {}

  // What a file of `what` begins with.
  void TakeMagic(const std::string& magic, const char* what) {
    if (bytes_.compare(0, magic.size(), magic) != 0)
      Fail(Concat("does not begin as a file of ", what));
    at_ = magic.size();
  }

  template <typename T>
  T Take() {
    T value{};
    std::memcpy(&value, Skip(sizeof(T)), sizeof(T));
    return value;
  }
  Rigid3d TakePose() {
    Rigid3d pose;
    for (double& number : pose.rotation.coeffs()) number = Take<double>();
    for (double& number : pose.translation) number = Take<double>();
    if (!pose.translation.allFinite() || !(std::abs(pose.rotation.norm() - 1) < 1e-6)) {
      Fail("has a pose that is none");
    }
    return pose;
  }
  // Of things that take so many bytes each at least.
  std::size_t TakeCount(std::size_t bytes_each) {
    const std::size_t count = Take<std::uint32_t>();
    if (count > (bytes_.size() - at_) / bytes_each) Fail("ends too early");
    return count;
  }
  int TakeBelow(std::size_t count, const char* what) {
    const int number = Take<int>();
    if (number < 0 || static_cast<std::size_t>(number) >= count) {
      Fail(Concat("names ", what, " ", number, " of ", count));
    }
    return number;
  }
  // Of a pixel's type; an empty one where it is passed over.
  template <typename T>
  Image<T> TakeImage(bool is_wanted = true) {
    const int width = Take<int>(), height = Take<int>();
    const std::size_t count = TakeCount(1);
    const char* compressed = Skip(count);
    if (!is_wanted) return {};
    const auto bytes = static_cast<std::uint64_t>(width) * height * sizeof(T);
    // zlib makes at most about 1000 bytes of one.
    if (width < 0 || height < 0 || width > 16384 || height > 16384 || bytes > kMostImageBytes ||
        bytes > 1100 * (count + 1)) {
      Fail(Concat("has an image of ", width, " x ", height));
    }
    Image<T> image(width, height);
    if (bytes > 0 && !Inflate(compressed, count, image.data(), bytes)) Fail("has a damaged image");
    return image;
  }
  void End() const {
    if (at_ != bytes_.size()) Fail("goes on after its end");
  }
  [[noreturn]] void Fail(const std::string& why) const { throw InputError(from_, ": ", why); }

 private:
  // What a damaged number may ask for.
  static constexpr std::uint64_t kMostImageBytes = std::uint64_t{64} << 20;

  const char* Skip(std::size_t count) {
    if (count > bytes_.size() - at_) Fail("ends too early");
    at_ += count;
    return bytes_.data() + at_ - count;
  }

  std::string bytes_;
  std::string from_;
  std::size_t at_ = 0;
};

// A view as bytes, and back. Throws InputError for one that is none.
void PutView(const PlaceView& view, Packer* packer);
PlaceView TakeView(PlacesPart part, Unpacker* unpacker);

}  // namespace surfit
