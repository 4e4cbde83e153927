#include "io/read_image.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "core/read_file.h"
#include "io/jpeg.h"
#include "io/png_check.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

cv::Mat Decode(const std::string& bytes, int flags, const std::string& path) {
  if (IsPng(bytes)) RequireWholePng(bytes, path);
  const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  cv::Mat image;
  try {
    if (!bytes.empty()) image = cv::imdecode(row, flags);
  } catch (const cv::Exception&) {  // leaves the image empty, as other failures do
  }
  if (image.empty()) throw InputError(path + " is truncated, damaged or no image");
  return image;
}

template <typename T>
Image<T> CopyPixels(const cv::Mat& source) {
  Image<T> image(source.cols, source.rows);
  for (int v = 0; v < source.rows; ++v) std::copy_n(source.ptr<T>(v), source.cols, image.row(v));
  return image;
}

}  // namespace

RawDepth ReadDepthImage(const std::string& path) { return DecodeDepthImage(ReadFile(path), path); }

RawDepth DecodeDepthImage(const std::string& bytes, const std::string& path) {
  const cv::Mat image = Decode(bytes, cv::IMREAD_UNCHANGED, path);
  if (image.type() == CV_16UC1) return CopyPixels<std::uint16_t>(image);
  if (image.type() == CV_32FC1) return CopyPixels<float>(image);
  throw InputError(Concat(path, " has ", image.channels(), " channel(s) of ", 8 * image.elemSize1(),
                          " bits, a depth image must have one of 16 bits or of 32-bit floats"));
}

Image<Rgb8> ReadColorImage(const std::string& path) {
  return DecodeColorImage(ReadFile(path), path);
}

Image<Rgb8> DecodeColorImage(const std::string& bytes, const std::string& path) {
  if (IsJpeg(bytes)) return DecodeJpeg(bytes, path);
  const cv::Mat bgr = Decode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION, path);
  Image<Rgb8> image = CopyPixels<Rgb8>(bgr);
  for (Rgb8& pixel : image) std::swap(pixel.r, pixel.b);
  return image;
}

}  // namespace surfit
