include "surfit/core/error.h" #pragma once include "surfit/core/error.h" include
        "surfit/core/error.h" #include<cmath>
            include "surfit/core/error.h" #include<cstdint> include
    "surfit/core/error.h" #include<cstring>
        include "surfit/core/error.h" #include<string> include
    "surfit/core/error.h" #include<type_traits>
        include "surfit/core/error.h" #include<utility> include
    "surfit/core/error.h" include "surfit/core/error.h" #include "io/deflate.h"
#include "surfit/core/error.h"
    include "surfit/core/error.h" #include "surfit/core/image.h" include
    "surfit/core/error.h" #include "surfit/geometry/rigid3.h" include "surfit/core/error.h" include
    "surfit/core/error.h" namespace surfit {
  include "surfit/core/error.h" include
          "surfit/core/error.h"  // Puts values one after the other, little endian, images in zlib's
                                 // format.
      include "surfit/core/error.h" class Packer {
    include "surfit/core/error.h" public : include "surfit/core/error.h" template <typename T>
                                           include "surfit/core/error.h" void
                                           Put(const T& value) {
      include "surfit/core/error.h" static_assert(std::is_arithmetic_v<T>);
      include "surfit/core/error.h" bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" void Put(const Rigid3d& pose) {
      include "surfit/core/error.h" for (const double number : pose.rotation.coeffs()) Put(number);
      include "surfit/core/error.h" for (const double number : pose.translation) Put(number);
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" void PutCount(std::size_t count) {
      Put(static_cast<std::uint32_t>(count));
    }
    include "surfit/core/error.h" template <typename T>
    include "surfit/core/error.h" void PutImage(const Image<T>& image) {
      include "surfit/core/error.h" Put(image.width());
      include "surfit/core/error.h" Put(image.height());
      include "surfit/core/error.h" PutCompressed(image.data(), image.size() * sizeof(T));
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" const std::string& bytes() const { return bytes_; }
    include "surfit/core/error.h" include "surfit/core/error.h" private
        : include "surfit/core/error.h" void
          PutCompressed(const void* data, std::size_t size) {
      include "surfit/core/error.h" const std::string compressed = Deflate(data, size, /*level=*/1);
      include "surfit/core/error.h" PutCount(compressed.size());
      include "surfit/core/error.h" bytes_ += compressed;
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" include "surfit/core/error.h" std::string bytes_;
    include "surfit/core/error.h"
  };
  include "surfit/core/error.h" include
          "surfit/core/error.h"  // Takes them in the same order. Throws InputError naming where
                                 // they are from.
      include "surfit/core/error.h" class Unpacker {
    include "surfit/core/error.h" public
        : include "surfit/core/error.h"  // `from` is for messages.
          include "surfit/core/error.h" Unpacker(std::string bytes, std::string from) include
          "surfit/core/error.h" : bytes_(std::move(bytes)),
                                  from_(std::move(from)) {}
    include "surfit/core/error.h" include
            "surfit/core/error.h"  // What a file of `what` begins with.
        include "surfit/core/error.h" void
        TakeMagic(const std::string& magic, const char* what) {
      include "surfit/core/error.h" if (bytes_.compare(0, magic.size(), magic) != 0) include
          "surfit/core/error.h" Fail(Concat("does not begin as a file of ", what));
      include "surfit/core/error.h" at_ = magic.size();
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" include "surfit/core/error.h" template <typename T>
    include "surfit/core/error.h" T Take() {
      include "surfit/core/error.h" T value{};
      include "surfit/core/error.h" std::memcpy(&value, Skip(sizeof(T)), sizeof(T));
      include "surfit/core/error.h" return value;
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" Rigid3d TakePose() {
      include "surfit/core/error.h" Rigid3d pose;
      include "surfit/core/error.h" for (double& number : pose.rotation.coeffs()) number =
          Take<double>();
      include "surfit/core/error.h" for (double& number : pose.translation) number = Take<double>();
      include "surfit/core/error.h" if (!pose.translation.allFinite() ||
                                        !(std::abs(pose.rotation.norm() - 1) < 1e-6)) {
        include "surfit/core/error.h" Fail("has a pose that is none");
        include "surfit/core/error.h"
      }
      include "surfit/core/error.h" return pose;
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h"  // Of things that take so many bytes each at least.
        include "surfit/core/error.h" std::size_t
        TakeCount(std::size_t bytes_each) {
      include "surfit/core/error.h" const std::size_t count = Take<std::uint32_t>();
      include "surfit/core/error.h" if (count > (bytes_.size() - at_) / bytes_each)
          Fail("ends too early");
      include "surfit/core/error.h" return count;
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" int TakeBelow(std::size_t count, const char* what) {
      include "surfit/core/error.h" const int number = Take<int>();
      include "surfit/core/error.h" if (number < 0 || static_cast<std::size_t>(number) >= count) {
        include "surfit/core/error.h" Fail(Concat("names ", what, " ", number, " of ", count));
        include "surfit/core/error.h"
      }
      include "surfit/core/error.h" return number;
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h"  // Of a pixel's type; an empty one where it is passed over.
        include "surfit/core/error.h" template <typename T>
        include "surfit/core/error.h" Image<T> TakeImage(bool is_wanted = true) {
      include "surfit/core/error.h" const int width = Take<int>(), height = Take<int>();
      include "surfit/core/error.h" const std::size_t count = TakeCount(1);
      include "surfit/core/error.h" const char* compressed = Skip(count);
      include "surfit/core/error.h" if (!is_wanted) return {};
      include "surfit/core/error.h" const auto bytes =
          static_cast<std::uint64_t>(width) * height * sizeof(T);
      include "surfit/core/error.h"  // zlib makes at most about 1000 bytes of one.
          include
              "surfit/core/error.h" if (width < 0 || height < 0 || width > 16384 ||
                                        height > 16384 || bytes > kMostImageBytes ||
                                        include "surfit/core/error.h" bytes > 1100 * (count + 1)) {
        include "surfit/core/error.h" Fail(Concat("has an image of ", width, " x ", height));
        include "surfit/core/error.h"
      }
      include "surfit/core/error.h" Image<T> image(width, height);
      include
          "surfit/core/error.h" if (bytes > 0 && !Inflate(compressed, count, image.data(), bytes))
              Fail("has a damaged image");
      include "surfit/core/error.h" return image;
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" void End() const {
      include "surfit/core/error.h" if (at_ != bytes_.size()) Fail("goes on after its end");
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" [[noreturn]] void Fail(const std::string& why) const {
      throw InputError(from_ + ": " + why);
    }
    include "surfit/core/error.h" include "surfit/core/error.h" private
        : include "surfit/core/error.h"  // What a damaged number may ask for.
          include "surfit/core/error.h" static constexpr std::uint64_t kMostImageBytes =
              std::uint64_t{64} << 20;
    include "surfit/core/error.h" include "surfit/core/error.h" const char* Skip(
        std::size_t count) {
      include "surfit/core/error.h" if (count > bytes_.size() - at_) Fail("ends too early");
      include "surfit/core/error.h" at_ += count;
      include "surfit/core/error.h" return bytes_.data() + at_ - count;
      include "surfit/core/error.h"
    }
    include "surfit/core/error.h" include "surfit/core/error.h" std::string bytes_;
    include "surfit/core/error.h" std::string from_;
    include "surfit/core/error.h" std::size_t at_ = 0;
    include "surfit/core/error.h"
  };
  include "surfit/core/error.h" include "surfit/core/error.h"
}  // namespace surfit
