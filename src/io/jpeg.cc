#include "io/jpeg.h"

#include <turbojpeg.h>

#include <memory>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kMaxSize = 16384;  // px, so that a damaged header cannot ask for all memory

struct Closer {
  void operator()(void* decoder) const { tjDestroy(decoder); }
};

}  // namespace

bool IsJpeg(const std::string& bytes) {
  return bytes.size() >= 2 && bytes[0] == '\xFF' && bytes[1] == '\xD8';
}

Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path) {
  static_assert(sizeof(Rgb8) == 3);
  const std::unique_ptr<void, Closer> decoder(tjInitDecompress());
  const auto require = [&](bool holds) {
    if (!holds)
      throw InputError(Concat(path, " is truncated or damaged: ", tjGetErrorStr2(decoder.get())));
  };
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, subsampling = 0, color_space = 0;
  require(tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling,
                              &color_space) == 0);
  if (width < 1 || height < 1 || width > kMaxSize || height > kMaxSize)
    throw InputError(Concat(path, " is ", width, " x ", height, " pixels, must be from 1 x 1 to ",
                            kMaxSize, " x ", kMaxSize));
  Image<Rgb8> image(width, height);
  require(tjDecompress2(decoder.get(), data, bytes.size(), &image.data()->r, width, 0, height,
                        TJPF_RGB, TJFLAG_STOPONWARNING) == 0);
  return image;
}

}  // namespace surfit
