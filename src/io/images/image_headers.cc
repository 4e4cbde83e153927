// Reads image sizes and PNG chunks from file headers, before a decoder allocates memory.
#include <libdeflate.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>

#include "io/images/image_kinds.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

const std::string kSignature = "\x89PNG\r\n\x1A\n";

std::uint32_t BigEndian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
}

const std::uint8_t* BytesOf(const std::string& bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

class TiffReader {
 public:
  explicit TiffReader(const std::string& bytes) : bytes_(bytes), is_little_(bytes[0] == 'I') {}

  // Reads a number of `size` bytes at offset `at`. Throws InputError with `path` if the file ends
  // before.
  std::uint32_t Number(std::size_t at, int size, const std::string& path) const {
    ThrowIf(at + size > bytes_.size(), path, " is truncated");
    std::uint32_t number = 0;
    for (int i = 0; i < size; ++i) {
      const std::size_t byte = is_little_ ? at + size - 1 - i : at + i;
      number = number << 8 | BytesOf(bytes_)[byte];
    }
    return number;
  }

 private:
  const std::string& bytes_;
  bool is_little_;
};

// Larger of image size and tile size per axis. The first directory has a 2-byte count, then entries
// of 12 bytes (TIFF 6.0). An entry has 2 bytes of tag, 2 of type, 4 of count and 4 of value.
ImageSize TiffSize(const std::string& bytes, const std::string& path) {
  constexpr std::uint32_t kWidth = 256, kHeight = 257, kTileWidth = 322, kTileHeight = 323;
  constexpr std::uint32_t kShort = 3, kLong = 4, kMost = 1 << 30;
  const TiffReader tiff(bytes);
  const std::size_t directory = tiff.Number(4, 4, path);
  const std::uint32_t count = tiff.Number(directory, 2, path);
  std::uint32_t width = 0, height = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t entry = directory + 2 + 12 * std::size_t{i};
    const std::uint32_t tag = tiff.Number(entry, 2, path), type = tiff.Number(entry + 2, 2, path);
    const bool is_width = tag == kWidth || tag == kTileWidth;
    if (!is_width && tag != kHeight && tag != kTileHeight) continue;
    ThrowIf(type != kShort && type != kLong, path,
            " is damaged: its width or height has a wrong type");
    std::uint32_t& side = is_width ? width : height;
    side = std::max(side, std::min(tiff.Number(entry + 8, type == kShort ? 2 : 4, path), kMost));
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

// Number of pixels per byte of a PNG with fewer than 8 bits per pixel; otherwise 1.
int PixelsOfByte(const std::string& bytes) {
  constexpr std::size_t kBitsAt = 24;
  const int bits = IsPng(bytes) && bytes.size() > kBitsAt ? BytesOf(bytes)[kBitsAt] : 8;
  return bits > 0 && bits < 8 ? 8 / bits : 1;
}

// Name of a known format that is not supported; "" for unknown bytes.
std::string OtherFormat(const std::string& bytes) {
  const auto has = [&](std::size_t at, const char* text) {
    return bytes.size() > at && bytes.compare(at, std::strlen(text), text) == 0;
  };
  if (has(0, "RIFF") && has(8, "WEBP")) return "WebP";
  if (has(4, "ftypavif")) return "AVIF";
  if (has(4, "ftyp")) return "HEIC";
  if (has(0, "BM")) return "BMP";
  if (has(0, "GIF8")) return "GIF";
  if (has(0, "\xFF\x0A") || has(4, "JXL ")) return "JPEG XL";
  if (has(4, "jP  ")) return "JPEG 2000";
  return "";
}

ImageSize SizeByKind(const std::string& bytes, const std::string& path) {
  if (IsPng(bytes)) return PngSize(bytes, path);
  if (IsJpeg(bytes)) return JpegSize(bytes, path);
  if (IsTiff(bytes)) return TiffSize(bytes, path);
  if (IsPnm(bytes)) return PnmSize(bytes, path);
  if (IsNpy(bytes)) return NpySize(bytes, path);
  if (IsExr(bytes)) return ExrSize(bytes, path);
  const std::string other = OtherFormat(bytes);
  ThrowIf(!other.empty(), path, " is a ", other,
          " file, must be PNG, JPEG, TIFF, PGM, PPM, EXR or NPY");
  throw InputError(path,
                   " is truncated, damaged or not an image: neither PNG, JPEG, TIFF, PGM, "
                   "PPM, EXR nor NPY");
}

}  // namespace

bool IsTiff(const std::string& bytes) {
  return bytes.compare(0, 4, std::string("II*\0", 4)) == 0 ||
         bytes.compare(0, 4, std::string("MM\0*", 4)) == 0;
}

bool IsPnm(const std::string& bytes) {
  return bytes.size() > 2 && bytes[0] == 'P' &&
         std::string("2356").find(bytes[1]) != std::string::npos;
}

void RequireValidSize(ImageSize size, const std::string& path) {
  constexpr int kMax = 16384;  // px
  if (size.width >= 1 && size.height >= 1 && size.width <= kMax && size.height <= kMax) return;
  throw InputError(path, " is ", size.width, " x ", size.height, " pixels, must be from 1 x 1 to ",
                   kMax, " x ", kMax);
}

ImageSize SizeInHeader(const std::string& bytes, const std::string& path) {
  constexpr std::size_t kMaxRatio = 1032;  // maximum compression ratio of deflate; JPEG: less
  const ImageSize size = SizeByKind(bytes, path);
  RequireValidSize(size, path);
  if (size.pixels() / kMaxRatio / PixelsOfByte(bytes) <= bytes.size()) return size;
  throw InputError(path, " is truncated or damaged: its ", bytes.size(), " bytes cannot hold ",
                   size.width, " x ", size.height, " pixels");
}

bool IsJpeg(const std::string& bytes) {
  return bytes.size() >= 2 && bytes[0] == '\xFF' && bytes[1] == '\xD8';
}

ImageSize JpegSize(const std::string& bytes, const std::string& path) {
  const auto close = [](void* handle) { tjDestroy(handle); };
  const std::unique_ptr<void, decltype(close)> decoder(tjInitDecompress(), close);
  ImageSize size;
  int subsampling = 0, color_space = 0;
  if (tjDecompressHeader3(decoder.get(), BytesOf(bytes), bytes.size(), &size.width, &size.height,
                          &subsampling, &color_space) != 0) {
    throw InputError(path, " is truncated or damaged: ", tjGetErrorStr2(decoder.get()));
  }
  ThrowIf(color_space == TJCS_CMYK || color_space == TJCS_YCCK, path,
          " is a CMYK JPEG file, its colours must be RGB, YCbCr or grey");
  RequireValidSize(size, path);
  return size;
}

bool IsPng(const std::string& bytes) {
  return bytes.compare(0, kSignature.size(), kSignature) == 0;
}

std::vector<PngChunk> PngChunks(const std::string& png, const std::string& path) {
  const std::uint8_t* const data = BytesOf(png);
  const std::string_view bytes = png;
  std::vector<PngChunk> chunks;
  std::size_t at = kSignature.size();
  do {
    // Chunk layout: length of the data, type, data, checksum of type and data.
    const std::size_t left = bytes.size() - at;
    ThrowIf(left < 12 || left - 12 < BigEndian(data + at), path, " is truncated");
    const std::size_t length = BigEndian(data + at);
    ThrowIf(libdeflate_crc32(0, data + at + 4, length + 4) != BigEndian(data + at + 8 + length),
            path, " is damaged: a checksum is wrong");
    chunks.push_back({bytes.substr(at + 4, 4), bytes.substr(at + 8, length)});
    at += length + 12;
  } while (chunks.back().type != "IEND");
  return chunks;
}

ImageSize PngSize(const std::string& bytes, const std::string& path) {
  // The IHDR chunk: length, type, width, height.
  constexpr std::size_t kSizeAt = 16;
  ThrowIf(!IsPng(bytes) || bytes.size() < kSizeAt + 8, path, " is truncated");
  const std::uint8_t* const data = BytesOf(bytes);
  const ImageSize size{static_cast<int>(BigEndian(data + kSizeAt)),
                       static_cast<int>(BigEndian(data + kSizeAt + 4))};
  RequireValidSize(size, path);
  return size;
}

}  // namespace surfit
