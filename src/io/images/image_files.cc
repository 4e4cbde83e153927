#include "io/images/image_files.h"

#include <turbojpeg.h>

#include <cstdio>
#include <memory>

#include "core/files.h"
#include "io/images/image_kinds.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::size_t kMaxOfImage = std::size_t{1} << 30;  // maximum file size, bytes

struct Closer {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Closer>;

void Require(bool holds, const Handle& decoder, const std::string& path) {
  if (holds) return;
  throw InputError(path, " is truncated or damaged: ", tjGetErrorStr2(decoder.get()));
}

// Throws InputError for formats that only have depth.
void RequireColorKind(const std::string& bytes, const std::string& path, const char* must) {
  ThrowIf(IsNpy(bytes) || IsExr(bytes), path, " is ", IsNpy(bytes) ? "an NPY" : "an EXR", " file, ",
          must);
}

// True for stray bytes between the last pixel and the end marker, as some cameras pad files. A
// damaged image usually has more of them.
bool IsOnlyPadded(const Handle& decoder) {
  constexpr int kMaxStray = 64;
  constexpr char kFormat[] = "Corrupt JPEG data: %d extraneous bytes before marker 0xd%c";
  int stray = 0;
  char marker = 0;
  return tjGetErrorCode(decoder.get()) == TJERR_WARNING &&
         std::sscanf(tjGetErrorStr2(decoder.get()), kFormat, &stray, &marker) == 2 &&
         marker == '9' && stray <= kMaxStray;
}

const unsigned char* Data(const std::string& bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

}  // namespace

InputError NotADepthImage(int channels, int bits, const std::string& path) {
  return InputError(
      Concat(path, " has ", channels, " channel(s) of ", bits,
             " bits, a depth image must have one of 16-bit integers or 32-bit floats"));
}

InputError NotAConfidenceImage(int channels, int bits, const std::string& path) {
  return InputError(Concat(path, " has ", channels, " channel(s) of ", bits,
                           " bits, a confidence image must have one of 8 bits"));
}

InputError DamagedImage(const std::string& path) {
  return InputError(path + " is truncated, damaged or not an image");
}

RawDepth ReadDepthImage(const std::string& path) {
  return DecodeDepthImage(ReadFile(path, kMaxOfImage), path);
}

RawDepth DecodeDepthImage(const std::string& bytes, const std::string& path) {
  SizeInHeader(bytes, path);
  if (IsPng(bytes)) return DecodeDepthPng(bytes, path);
  if (IsTiff(bytes)) return DecodeDepthTiff(bytes, path);
  if (IsPnm(bytes)) return DecodeDepthPnm(bytes, path);
  if (IsNpy(bytes)) return DecodeDepthNpy(bytes, path);
  if (IsExr(bytes)) return DecodeDepthExr(bytes, path);
  throw InputError(path, " is a JPEG file, a depth image must be PNG, TIFF, PGM, EXR or NPY");
}

Image<std::uint8_t> ReadConfidenceImage(const std::string& path) {
  return DecodeConfidenceImage(ReadFile(path, kMaxOfImage), path);
}

Image<std::uint8_t> DecodeConfidenceImage(const std::string& bytes, const std::string& path) {
  SizeInHeader(bytes, path);
  if (IsPng(bytes)) return DecodeConfidencePng(bytes, path);
  if (IsTiff(bytes)) return DecodeConfidenceTiff(bytes, path);
  if (IsPnm(bytes)) return DecodeConfidencePnm(bytes, path);
  RequireColorKind(bytes, path, "a confidence image must be PNG, TIFF or PGM");
  throw InputError(path, " is a JPEG, a confidence image must be PNG, TIFF or PGM");
}

Image<Rgb8> ReadColorImage(const std::string& path) {
  return DecodeColorImage(ReadFile(path, kMaxOfImage), path);
}

Image<Rgb8> DecodeColorImage(const std::string& bytes, const std::string& path) {
  SizeInHeader(bytes, path);
  if (IsPng(bytes)) return DecodeColorPng(bytes, path);
  if (IsTiff(bytes)) return DecodeColorTiff(bytes, path);
  if (IsPnm(bytes)) return DecodeColorPnm(bytes, path);
  RequireColorKind(bytes, path, "a colour image must be PNG, JPEG, TIFF or PPM");
  return DecodeJpeg(bytes, path);
}

Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path) {
  static_assert(sizeof(Rgb8) == 3);
  const Handle decoder(tjInitDecompress());
  const ImageSize size = SizeInHeader(bytes, path);
  Image<Rgb8> image(size.width, size.height);
  const auto decode = [&](int flags) {
    return tjDecompress2(decoder.get(), Data(bytes), bytes.size(), &image.data()->r, size.width, 0,
                         size.height, TJPF_RGB, flags) == 0;
  };
  if (decode(TJFLAG_STOPONWARNING)) return image;
  Require(IsOnlyPadded(decoder) && (decode(0) || IsOnlyPadded(decoder)), decoder, path);
  return image;
}

std::string EncodeJpeg(const Image<Rgb8>& image, int quality) {
  const Handle encoder(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int result = tjCompress2(encoder.get(), &image.data()->r, image.width(), 0, image.height(),
                                 TJPF_RGB, &bytes, &size, TJSAMP_444, quality, 0);
  if (result != 0) {
    throw InputError("cannot encode a JPEG of ", image.width(), " x ", image.height(),
                     " pixels: ", tjGetErrorStr2(encoder.get()));
  }
  std::string jpeg(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  return jpeg;
}

}  // namespace surfit
