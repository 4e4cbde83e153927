// PGM and PPM files (netpbm manual). P2 and P3 store numbers as text, P5 and P6 as bytes. Numbers
// have two bytes, big endian, if the maximum value is above 255.
#include <algorithm>
#include <cctype>
#include <cstdint>

#include "io/images/image_kinds.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

class PnmReader {
 public:
  PnmReader(const std::string& bytes, const std::string& path) : bytes_(bytes), path_(path) {
    size_.width = TakeText();
    size_.height = TakeText();
  }

  // Reads the maximum value. Call before Take(). Throws InputError if the file is too short for its
  // pixels.
  void Begin() {
    most_ = TakeText();
    if (most_ < 1 || most_ > 65535) throw DamagedImage(path_);
    ++at_;  // separator
    const std::size_t numbers = channels() * size_.pixels();
    // A number as text has at least one digit, and a separator before the next number.
    const std::size_t least = is_text() ? 2 * numbers - 1 : numbers * bits() / 8;
    ThrowIf(at_ > bytes_.size() || bytes_.size() - at_ < least, path_, " is truncated");
  }

  ImageSize size() const { return size_; }
  int channels() const { return bytes_[1] == '3' || bytes_[1] == '6' ? 3 : 1; }
  int bits() const { return most_ > 255 ? 16 : 8; }
  int most() const { return most_; }

  int Take() { return is_text() ? TakeText() : TakeBytes(); }

 private:
  bool is_text() const { return bytes_[1] == '2' || bytes_[1] == '3'; }

  int TakeBytes() {
    int number = Byte(at_++);
    if (bits() == 16) number = number << 8 | Byte(at_++);
    return number;
  }

  // Skips blanks and comment lines, then reads a number.
  int TakeText() {
    while (at_ < bytes_.size() && (std::isspace(Byte(at_)) != 0 || bytes_[at_] == '#'))
      at_ = bytes_[at_] == '#' ? bytes_.find_first_of("\r\n", at_) : at_ + 1;
    ThrowIf(at_ >= bytes_.size() || std::isdigit(Byte(at_)) == 0, path_,
            " is truncated or damaged: a number is missing");
    constexpr int kMost = 1 << 20;
    int number = 0;
    for (; at_ < bytes_.size() && std::isdigit(Byte(at_)) != 0; ++at_)
      number = std::min(kMost, 10 * number + (bytes_[at_] - '0'));
    return number;
  }

  std::uint8_t Byte(std::size_t at) const { return static_cast<std::uint8_t>(bytes_[at]); }

  const std::string& bytes_;
  const std::string& path_;
  std::size_t at_ = 2;
  ImageSize size_;
  int most_ = 0;
};

}  // namespace

ImageSize PnmSize(const std::string& bytes, const std::string& path) {
  return PnmReader(bytes, path).size();
}

RawDepth DecodeDepthPnm(const std::string& bytes, const std::string& path) {
  PnmReader reader(bytes, path);
  reader.Begin();
  if (reader.channels() != 1 || reader.bits() != 16)
    throw NotADepthImage(reader.channels(), reader.bits(), path);
  Image<std::uint16_t> image(reader.size().width, reader.size().height);
  for (std::uint16_t& count : image)
    count = static_cast<std::uint16_t>(std::min(reader.Take(), reader.most()));
  return image;
}

Image<std::uint8_t> DecodeConfidencePnm(const std::string& bytes, const std::string& path) {
  PnmReader reader(bytes, path);
  reader.Begin();
  if (reader.channels() != 1 || reader.bits() != 8)
    throw NotAConfidenceImage(reader.channels(), reader.bits(), path);
  Image<std::uint8_t> image(reader.size().width, reader.size().height);
  for (std::uint8_t& value : image)
    value = static_cast<std::uint8_t>(std::min(reader.Take(), reader.most()));
  return image;
}

Image<Rgb8> DecodeColorPnm(const std::string& bytes, const std::string& path) {
  PnmReader reader(bytes, path);
  reader.Begin();
  const auto take = [&] {
    const int most = reader.most();
    return static_cast<std::uint8_t>((std::min(reader.Take(), most) * 255 + most / 2) / most);
  };
  Image<Rgb8> image(reader.size().width, reader.size().height);
  for (Rgb8& pixel : image) {
    pixel.r = take();
    pixel.g = reader.channels() == 3 ? take() : pixel.r;
    pixel.b = reader.channels() == 3 ? take() : pixel.r;
  }
  return image;
}

}  // namespace surfit
