#include "io/image_files.h"

#include <turbojpeg.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <opencv2/imgcodecs.hpp>

#include "core/read_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::size_t kMostOfImage = std::size_t{1} << 30;  // bytes of a file

cv::Mat Decode(const std::string& bytes, int flags, const std::string& path) {
  if (IsPng(bytes)) RequireWholePng(bytes, path);
  ClaimedSize(bytes, path);
  const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  cv::Mat image;
  try {
    if (!bytes.empty()) image = cv::imdecode(row, flags);
  } catch (const cv::Exception&) {  // leaves the image empty, as other failures do
  }
  if (image.empty()) throw InputError(path + " is truncated, damaged or not an image");
  return image;
}

template <typename T>
Image<T> CopyPixels(const cv::Mat& source) {
  Image<T> image(source.cols, source.rows);
  for (int v = 0; v < source.rows; ++v) std::copy_n(source.ptr<T>(v), source.cols, image.row(v));
  return image;
}

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

}  // namespace

RawDepth ReadDepthImage(const std::string& path) {
  return DecodeDepthImage(ReadFile(path, kMostOfImage), path);
}

RawDepth DecodeDepthImage(const std::string& bytes, const std::string& path) {
  const cv::Mat image = Decode(bytes, cv::IMREAD_UNCHANGED, path);
  if (image.type() == CV_16UC1) return CopyPixels<std::uint16_t>(image);
  if (image.type() == CV_32FC1) return CopyPixels<float>(image);
  throw InputError(Concat(path, " has ", image.channels(), " channel(s) of ", 8 * image.elemSize1(),
                          " bits, a depth image must have one of 16 bits or of 32-bit floats"));
}

Image<Rgb8> ReadColorImage(const std::string& path) {
  return DecodeColorImage(ReadFile(path, kMostOfImage), path);
}

Image<Rgb8> DecodeColorImage(const std::string& bytes, const std::string& path) {
  if (IsJpeg(bytes)) return DecodeJpeg(bytes, path);
  const cv::Mat bgr = Decode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION, path);
  Image<Rgb8> image = CopyPixels<Rgb8>(bgr);
  for (Rgb8& pixel : image) std::swap(pixel.r, pixel.b);
  return image;
}

Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path) {
  static_assert(sizeof(Rgb8) == 3);
  const Handle decoder(tjInitDecompress());
  const ImageSize size = ClaimedSize(bytes, path);
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
  if (result != 0) {
    throw InputError(Concat("cannot make a JPEG of ", image.width(), " x ", image.height(),
                            " pixels: ", tjGetErrorStr2(encoder.get())));
  }
  const std::string jpeg(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  return jpeg;
}

}  // namespace surfit
