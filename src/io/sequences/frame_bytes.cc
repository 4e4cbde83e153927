#include "io/sequences/frame_bytes.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/images/deflate.h"

namespace surfit {
namespace {

template <typename T>
Image<T> CopyPixels(const std::string& bytes, ImageSize size, const std::string& name) {
  ThrowIf(bytes.size() != sizeof(T) * size.pixels(), name, " has ", bytes.size(),
          " bytes, must have ", sizeof(T) * size.pixels(), " for ", size.width, " x ", size.height,
          " pixels");
  Image<T> image(size.width, size.height);
  std::memcpy(image.data(), bytes.data(), bytes.size());
  return image;
}

Image<std::uint16_t> InflateDepth(const std::string& bytes, ImageSize size,
                                  const std::string& name) {
  constexpr std::size_t kMaxRatio = 1032;  // maximum ratio of deflate: 258 bytes from 2 bits
  const std::size_t count = 2 * size.pixels();
  const auto damaged = [&] {
    return InputError(Concat(name, " is damaged: its ", bytes.size(),
                             " bytes do not decompress to ", size.width, " x ", size.height,
                             " 16-bit values"));
  };
  if (count / kMaxRatio > bytes.size()) throw damaged();
  Image<std::uint16_t> image(size.width, size.height);
  if (!Inflate(bytes.data(), bytes.size(), image.data(), count)) throw damaged();
  return image;
}

Image<Rgb8> DecodeColor(const std::string& bytes, ImageSize size, const std::string& name) {
  ThrowIf(!IsJpeg(bytes) && !IsPng(bytes), name, " is damaged: neither JPEG nor PNG");
  const ImageSize claimed = IsPng(bytes) ? PngSize(bytes, name) : JpegSize(bytes, name);
  ThrowIf(claimed != size, name, " is ", claimed.width, " x ", claimed.height, " pixels, must be ",
          size.width, " x ", size.height);
  return DecodeColorImage(bytes, name);
}

}  // namespace

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "values are copied from memory");

BinaryFile::BinaryFile(const std::string& path) : path_(path), file_(path, std::ios::binary) {
  if (file_.seekg(0, std::ios::end)) size_ = file_.tellg();
  if (!file_) {
    const std::error_code reason(errno, std::generic_category());
    throw InputError("cannot read '", path, "': ", reason.message());
  }
}

std::string BinaryFile::Read(std::uint64_t at, std::uint64_t count) const {
  ThrowIf(!Has(at, count), path_, " has ", size_, " bytes, cannot read ", count,
          " bytes at offset ", at);
  std::string bytes(count, '\0');
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(at));
  ThrowIf(!file_.read(bytes.data(), static_cast<std::streamsize>(count)), "cannot read '", path_,
          "' at offset ", at);
  return bytes;
}

FrameImages ReadImages(const BinaryFile& file, int frame, const ImageBytes& depth,
                       const ImageBytes& color) {
  FrameImages images;
  images.depth_name = Concat(file.path(), ": depth of frame ", frame);
  images.color_name = Concat(file.path(), ": colour of frame ", frame);
  const std::string depth_bytes = file.Read(depth.at, depth.count);
  images.depth = depth.is_raw
                     ? CopyPixels<std::uint16_t>(depth_bytes, depth.size, images.depth_name)
                     : InflateDepth(depth_bytes, depth.size, images.depth_name);
  if (color.count == 0) return images;
  const std::string color_bytes = file.Read(color.at, color.count);
  images.color = color.is_raw ? CopyPixels<Rgb8>(color_bytes, color.size, images.color_name)
                              : DecodeColor(color_bytes, color.size, images.color_name);
  return images;
}

}  // namespace surfit
