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

// Serialises values in the byte order of the processor, which is little-endian on all supported
// processors, and images in the zlib format. The caller writes the signature. Counts must be below
// 2^32. The reader rejects images of more than 16384 px in width or height, or of more than 64 MiB.
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

// Deserialises the values in the same order. All functions throw InputError with `from` if the
// bytes end too early or are invalid. The order is: TakeMagic() first, End() last.
class Unpacker {
 public:
  // `from`: source of the bytes, for error messages.
  Unpacker(std::string bytes, std::string from)
      : bytes_(std::move(bytes)), from_(std::move(from)) {}

  // `what`: content of the file, for the error message.
  void TakeMagic(const std::string& magic, const char* what) {
    if (bytes_.compare(0, magic.size(), magic) != 0)
      Fail(Concat("does not begin with the signature of a file of ", what));
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
      Fail("has an invalid pose");
    }
    return pose;
  }
  // Number of items of at least `bytes_each` (positive) bytes each.
  std::size_t TakeCount(std::size_t bytes_each) {
    const std::size_t count = Take<std::uint32_t>();
    if (count > (bytes_.size() - at_) / bytes_each) Fail("ends too early");
    return count;
  }
  // Index in [0, count). `what`: name of the indexed item, for the error message.
  int TakeBelow(std::size_t count, const char* what) {
    const int number = Take<int>();
    if (number < 0 || static_cast<std::size_t>(number) >= count) {
      Fail(Concat("has the index of ", what, " ", number, ", must be below ", count));
    }
    return number;
  }
  // Image with pixels of type T. If not `is_wanted`: skips it and returns an empty image.
  template <typename T>
  Image<T> TakeImage(bool is_wanted = true) {
    const int width = Take<int>(), height = Take<int>();
    const std::size_t count = TakeCount(1);
    const char* compressed = Skip(count);
    if (!is_wanted) return {};
    const auto bytes = static_cast<std::uint64_t>(width) * height * sizeof(T);
    // The compression ratio of zlib is at most 1032.
    if (width < 0 || height < 0 || width > 16384 || height > 16384 || bytes > kMaxImageBytes ||
        bytes > 1100 * (count + 1)) {
      Fail(Concat("has an image of invalid size ", width, " x ", height));
    }
    Image<T> image(width, height);
    if (bytes > 0 && !Inflate(compressed, count, image.data(), bytes)) Fail("has a damaged image");
    return image;
  }
  bool IsAtEnd() const { return at_ == bytes_.size(); }
  void End() const {
    if (at_ != bytes_.size()) Fail("has bytes after its end");
  }
  [[noreturn]] void Fail(const std::string& why) const { throw InputError(from_, ": ", why); }

 private:
  // Maximum size of an image, so that a damaged size does not exhaust the memory.
  static constexpr std::uint64_t kMaxImageBytes = std::uint64_t{64} << 20;

  const char* Skip(std::size_t count) {
    if (count > bytes_.size() - at_) Fail("ends too early");
    at_ += count;
    return bytes_.data() + at_ - count;
  }

  std::string bytes_;
  std::string from_;
  std::size_t at_ = 0;
};

// Serialisation of a view. TakeView() throws InputError for damaged bytes, and for an invalid
// camera or noise. With PlacesPart::kFeatures its images are empty. Without a depth image, camera
// and noise are not checked. Distortion and PlaceView::field are not stored.
void PutView(const PlaceView& view, Packer* packer);
PlaceView TakeView(PlacesPart part, Unpacker* unpacker);

// PlaceView::field. Files of version 0.1 have no fields.
void PutField(const InverseDepthField& field, Packer* packer);
InverseDepthField TakeField(Unpacker* unpacker);

}  // namespace surfit
