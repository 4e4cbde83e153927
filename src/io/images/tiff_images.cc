// Decodes the first image of a TIFF file in memory with libtiff.
#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "io/images/image_kinds.h"

namespace surfit {
namespace {

struct TiffSource {
  const std::string& bytes;
  std::uint64_t at = 0;
};

tmsize_t TiffReadBytes(thandle_t handle, void* to, tmsize_t count) {
  auto* const source = static_cast<TiffSource*>(handle);
  const std::uint64_t size = source->bytes.size(), begin = std::min(source->at, size);
  const std::uint64_t taken = std::min<std::uint64_t>(count, size - begin);
  std::memcpy(to, source->bytes.data() + begin, taken);
  source->at = begin + taken;
  return static_cast<tmsize_t>(taken);
}

tmsize_t TiffRefuseToWrite(thandle_t, void*, tmsize_t) { return 0; }

toff_t TiffSeek(thandle_t handle, toff_t offset, int from) {
  auto* const source = static_cast<TiffSource*>(handle);
  if (from == SEEK_CUR) offset += source->at;
  if (from == SEEK_END) offset += source->bytes.size();
  return source->at = offset;
}

int TiffLeaveOpen(thandle_t) { return 0; }
toff_t TiffByteCount(thandle_t handle) { return static_cast<TiffSource*>(handle)->bytes.size(); }

// Suppresses messages of libtiff. Errors are detected by return values.
int TiffSilent(TIFF*, void*, const char*, const char*, va_list) { return 1; }

struct TiffOptionsFreer {
  void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};
struct TiffCloser {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

class TiffFile {
 public:
  // Reads the first directory. Throws InputError with `path`. Both arguments must outlive the
  // object.
  TiffFile(const std::string& bytes, const std::string& path) : path_(path), source_{bytes} {
    const std::unique_ptr<TIFFOpenOptions, TiffOptionsFreer> options(TIFFOpenOptionsAlloc());
    if (options == nullptr) throw std::bad_alloc();
    constexpr tmsize_t kMaxAtOnce = tmsize_t{1} << 30;  // bytes, enough for the largest image
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxAtOnce);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), TiffSilent, nullptr);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), TiffSilent, nullptr);
    tiff_.reset(TIFFClientOpenExt(path.c_str(), "rm", &source_, TiffReadBytes, TiffRefuseToWrite,
                                  TiffSeek, TiffLeaveOpen, TiffByteCount, nullptr, nullptr,
                                  options.get()));
    Require(tiff_ != nullptr);
    size_ = {static_cast<int>(Tag<std::uint32_t>(TIFFTAG_IMAGEWIDTH)),
             static_cast<int>(Tag<std::uint32_t>(TIFFTAG_IMAGELENGTH))};
    RequireValidSize(size_, path);
  }

  int channels() const { return Tag<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL); }
  int bits() const { return Tag<std::uint16_t>(TIFFTAG_BITSPERSAMPLE); }
  bool Has(int bits_of_one_channel, int format) const {
    return channels() == 1 && bits() == bits_of_one_channel &&
           Tag<std::uint16_t>(TIFFTAG_SAMPLEFORMAT) == format;
  }

  template <typename T>
  Image<T> ReadNumbers() const {
    return TIFFIsTiled(tiff_.get()) != 0 ? ReadTiles<T>() : ReadRows<T>();
  }

  Image<Rgb8> ReadColor() const {
    std::vector<std::uint32_t> pixels(size_.pixels());
    // Requests the orientation of the file, so that libtiff does not rotate the image.
    Require(TIFFReadRGBAImageOriented(tiff_.get(), size_.width, size_.height, pixels.data(),
                                      Tag<std::uint16_t>(TIFFTAG_ORIENTATION),
                                      /*stop_on_error=*/1) != 0);
    Image<Rgb8> image(size_.width, size_.height);
    std::transform(pixels.begin(), pixels.end(), image.begin(), [](std::uint32_t pixel) {
      return Rgb8{static_cast<std::uint8_t>(TIFFGetR(pixel)),
                  static_cast<std::uint8_t>(TIFFGetG(pixel)),
                  static_cast<std::uint8_t>(TIFFGetB(pixel))};
    });
    return image;
  }

 private:
  void Require(bool holds) const {
    if (!holds) throw DamagedImage(path_);
  }

  // A missing tag has the default of the TIFF specification, or 0 if there is no default.
  template <typename T>
  T Tag(std::uint32_t tag) const {
    T value = 0;
    return TIFFGetFieldDefaulted(tiff_.get(), tag, &value) == 1 ? value : T{0};
  }

  template <typename T>
  Image<T> ReadRows() const {
    Require(TIFFScanlineSize64(tiff_.get()) == sizeof(T) * size_.width);
    Image<T> image(size_.width, size_.height);
    for (int v = 0; v < size_.height; ++v)
      Require(TIFFReadScanline(tiff_.get(), image.row(v), v, 0) == 1);
    return image;
  }

  template <typename T>
  Image<T> ReadTiles() const {
    const int width = static_cast<int>(Tag<std::uint32_t>(TIFFTAG_TILEWIDTH));
    const int height = static_cast<int>(Tag<std::uint32_t>(TIFFTAG_TILELENGTH));
    RequireValidSize({width, height}, path_);
    Image<T> image(size_.width, size_.height), tile(width, height);
    const auto bytes = static_cast<tmsize_t>(sizeof(T) * tile.size());
    Require(TIFFTileSize(tiff_.get()) == bytes);
    for (int top = 0; top < size_.height; top += height) {
      for (int left = 0; left < size_.width; left += width) {
        Require(TIFFReadTile(tiff_.get(), tile.data(), left, top, 0, 0) == bytes);
        for (int v = 0; v < std::min(height, size_.height - top); ++v)
          std::copy_n(tile.row(v), std::min(width, size_.width - left), image.row(top + v) + left);
      }
    }
    return image;
  }

  const std::string& path_;
  TiffSource source_;
  std::unique_ptr<TIFF, TiffCloser> tiff_;
  ImageSize size_;
};

}  // namespace

RawDepth DecodeDepthTiff(const std::string& bytes, const std::string& path) {
  const TiffFile reader(bytes, path);
  if (reader.Has(16, SAMPLEFORMAT_UINT)) return reader.ReadNumbers<std::uint16_t>();
  if (reader.Has(32, SAMPLEFORMAT_IEEEFP)) return reader.ReadNumbers<float>();
  throw NotADepthImage(reader.channels(), reader.bits(), path);
}

Image<std::uint8_t> DecodeConfidenceTiff(const std::string& bytes, const std::string& path) {
  const TiffFile reader(bytes, path);
  if (reader.Has(8, SAMPLEFORMAT_UINT)) return reader.ReadNumbers<std::uint8_t>();
  throw NotAConfidenceImage(reader.channels(), reader.bits(), path);
}

Image<Rgb8> DecodeColorTiff(const std::string& bytes, const std::string& path) {
  return TiffFile(bytes, path).ReadColor();
}

}  // namespace surfit
