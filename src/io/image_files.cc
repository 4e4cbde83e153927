#include "io/image_files.h"

#include <glog/logging.h>
#include <turbojpeg.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <opencv2/imgcodecs.hpp>

#include "core/read_file.h"
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

ImageSize ReadHeader(const Handle& decoder, const std::string& bytes, const std::string& path) {
  ImageSize size;
  int subsampling = 0, color_space = 0;
  Require(tjDecompressHeader3(decoder.get(), Data(bytes), bytes.size(), &size.width, &size.height,
                              &subsampling, &color_space) == 0,
          decoder, path);
  RequireUsualSize(size, path);
  return size;
}

const std::string kSignature = "\x89PNG\r\n\x1A\n";

std::uint32_t BigEndian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
}

}  // namespace

void RequireUsualSize(ImageSize size, const std::string& path) {
  constexpr int kMax = 16384;  // px
  if (size.width >= 1 && size.height >= 1 && size.width <= kMax && size.height <= kMax) return;
  throw InputError(Concat(path, " is ", size.width, " x ", size.height,
                          " pixels, must be from 1 x 1 to ", kMax, " x ", kMax));
}

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
