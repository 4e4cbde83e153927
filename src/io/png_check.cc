#include "io/png_check.h"

#include <zlib.h>

#include <cstdint>

#include "surfit/core/error.h"

namespace surfit {
namespace {

const std::string kSignature = "\x89PNG\r\n\x1A\n";

std::uint32_t BigEndian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
}

}  // namespace

bool IsPng(const std::string& bytes) {
  return bytes.compare(0, kSignature.size(), kSignature) == 0;
}

void RequireWholePng(const std::string& bytes, const std::string& path) {
  const auto* const data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  std::size_t at = kSignature.size();
  while (true) {
    // A chunk: length of the data, type, data, checksum of type and data.
    const std::size_t left = bytes.size() - at;
    if (left < 12 || left - 12 < BigEndian(data + at)) throw InputError(path + " is truncated");
    const std::size_t length = BigEndian(data + at);
    const auto checksum = crc32(0, data + at + 4, static_cast<uInt>(length + 4));
    if (checksum != BigEndian(data + at + 8 + length))
      throw InputError(path + " is damaged: a checksum is wrong");
    if (bytes.compare(at + 4, 4, "IEND") == 0) return;
    at += length + 12;
  }
}

ImageSize PngSize(const std::string& bytes, const std::string& path) {
  // After the signature comes IHDR: length, type, width, height.
  constexpr std::size_t kSizeAt = 16;
  if (!IsPng(bytes) || bytes.size() < kSizeAt + 8) throw InputError(path + " is truncated");
  const auto* const data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const ImageSize size{static_cast<int>(BigEndian(data + kSizeAt)),
                       static_cast<int>(BigEndian(data + kSizeAt + 4))};
  RequireUsualSize(size, path);
  return size;
}

}  // namespace surfit
