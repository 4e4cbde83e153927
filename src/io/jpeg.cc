#include "io/jpeg.h"

#include <glog/logging.h>
#include <turbojpeg.h>

#include <memory>

#include "surfit/core/error.h"

namespace surfit {
namespace {

struct Closer {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Closer>;

void Require(bool holds, const Handle& decoder, const std::string& path) {
  if (holds) return;
  throw InputError(Concat(path, " is truncated or damaged: ", tjGetErrorStr2(decoder.get())));
}

const unsigned char* Data(const std::string& bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

ImageSize ReadHeader(const Handle& decoder, const std::string& bytes, const std::string& path) {
  ImageSize size;
  int subsampling = 0, color_space = 0;
  Require(tjDecompressHeader3(decoder.get(), Data(bytes), bytes.size(), &size.width, &size.height,
                              &subsampling, &color_space) == 0,
          decoder, path);
  RequireUsualSize(size, path);
  return size;
}

}  // namespace

bool IsJpeg(const std::string& bytes) {
  return bytes.size() >= 2 && bytes[0] == '\xFF' && bytes[1] == '\xD8';
}

ImageSize JpegSize(const std::string& bytes, const std::string& path) {
  return ReadHeader(Handle(tjInitDecompress()), bytes, path);
}

Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path) {
  static_assert(sizeof(Rgb8) == 3);
  const Handle decoder(tjInitDecompress());
  const ImageSize size = ReadHeader(decoder, bytes, path);
  Image<Rgb8> image(size.width, size.height);
  Require(tjDecompress2(decoder.get(), Data(bytes), bytes.size(), &image.data()->r, size.width, 0,
                        size.height, TJPF_RGB, TJFLAG_STOPONWARNING) == 0,
          decoder, path);
  return image;
}

std::string EncodeJpeg(const Image<Rgb8>& image, int quality) {
  const Handle encoder(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int result = tjCompress2(encoder.get(), &image.data()->r, image.width(), 0, image.height(),
                                 TJPF_RGB, &bytes, &size, TJSAMP_444, quality, 0);
  CHECK_EQ(result, 0) << tjGetErrorStr2(encoder.get());
  const std::string jpeg(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  return jpeg;
}

}  // namespace surfit
