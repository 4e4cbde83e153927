#pragma once

#include <zlib.h>

#include <array>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {

// Encoders of .klg and .sens files that are independent of the library.

template <typename... Values>
std::string LittleEndian(Values... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
  return bytes;
}

template <typename T>
std::string RawBytes(const Image<T>& image) {
  return {reinterpret_cast<const char*>(image.data()), image.size() * sizeof(T)};
}

inline std::string ZlibBytes(const Image<std::uint16_t>& depth) {
  uLongf size = compressBound(2 * depth.size());
  std::string bytes(size, '\0');
  compress(reinterpret_cast<Bytef*>(bytes.data()), &size,
           reinterpret_cast<const Bytef*>(depth.data()), 2 * depth.size());
  bytes.resize(size);
  return bytes;
}

// ".png" or ".jpg".
inline std::string EncodedBytes(const Image<Rgb8>& color, const std::string& kind) {
  cv::Mat bgr(color.height(), color.width(), CV_8UC3);
  for (std::size_t i = 0; i < color.size(); ++i)
    bgr.at<cv::Vec3b>(static_cast<int>(i)) = {color[i].b, color[i].g, color[i].r};
  std::vector<unsigned char> bytes;
  cv::imencode(kind, bgr, bytes);
  return {bytes.begin(), bytes.end()};
}

inline std::string KlgFrame(std::int64_t stamp_us, const std::string& depth,
                            const std::string& color) {
  return LittleEndian(stamp_us, static_cast<std::int32_t>(depth.size()),
                      static_cast<std::int32_t>(color.size())) +
         depth + color;
}

// A .klg file with `count` small numbered frames at 10 Hz, starting at 5 s. `color`: "" for raw,
// ".jpg" or "none".
inline std::string KlgFile(int count, bool zlib, const std::string& color) {
  std::string file = LittleEndian(static_cast<std::int32_t>(count));
  for (int i = 0; i < count; ++i) {
    const auto depth = NumberedDepth(i);
    const auto rgb = NumberedColor(i);
    const std::string color_bytes =
        color == "none" ? "" : (color.empty() ? RawBytes(rgb) : EncodedBytes(rgb, color));
    file += KlgFrame(5000000 + 100000 * i, zlib ? ZlibBytes(depth) : RawBytes(depth), color_bytes);
  }
  return file;
}

using Matrix16 = std::array<float, 16>;  // 4 x 4, row-major

inline Matrix16 TranslationMatrix(float x, float y, float z) {
  return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1};
}

// Encoder of .sens files with small numbered frames. The colour camera has twice their size.
struct SensEncoder {
  int depth_coding = 1;      // 0 raw, 1 zlib; others have zlib bytes
  std::string color_coding;  // "": raw, ".png", ".jpg", or "none": no colour
  bool has_stamps = true;    // 10 Hz from time 5
  int depth_delay_us = 0;    // delay of depth timestamps after colour timestamps
  bool registered = false;   // colour has the pixels of depth
  Matrix16 color_extrinsics = TranslationMatrix(0, 0, 0);
  std::vector<Matrix16>
      poses;  // one per frame; default of further frames: translation (number, 2, 3)

  std::string Header(std::uint64_t count) const {
    const Matrix16 depth_intrinsics = {31, 0, 15.5f, 0, 0, 30, 11.5f, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const Matrix16 color_intrinsics = {62, 0, 31, 0, 0, 60, 23, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const int scale = registered ? 1 : 2;
    const int color = color_coding == ".png" ? 1 : (color_coding == ".jpg" ? 2 : 0);
    return LittleEndian(std::uint32_t{4}, std::uint64_t{6}) + "sensor" +
           LittleEndian(registered ? depth_intrinsics : color_intrinsics, color_extrinsics,
                        depth_intrinsics, TranslationMatrix(0, 0, 0), color, depth_coding,
                        32 * scale, 24 * scale, 32, 24, 1000.f, count);
  }
  std::string Frame(int i) const {
    const int scale = registered ? 1 : 2;
    const auto rgb = NumberedColor(i, 32 * scale, 24 * scale);
    const std::string color =
        color_coding == "none"
            ? ""
            : (color_coding.empty() ? RawBytes(rgb) : EncodedBytes(rgb, color_coding));
    const auto raw = NumberedDepth(i);
    const std::string depth = depth_coding == 0 ? RawBytes(raw) : ZlibBytes(raw);
    const std::uint64_t stamp_us = has_stamps ? 5000000 + 100000 * i : 0;
    const Matrix16 pose = i < static_cast<int>(poses.size())
                              ? poses[i]
                              : TranslationMatrix(static_cast<float>(i), 2, 3);
    return LittleEndian(pose, stamp_us, stamp_us + depth_delay_us, std::uint64_t{color.size()},
                        std::uint64_t{depth.size()}) +
           color + depth;
  }
  std::string File(int count) const {
    std::string file = Header(count);
    for (int i = 0; i < count; ++i) file += Frame(i);
    return file + LittleEndian(std::uint64_t{0});  // no inertial data
  }
};

}  // namespace surfit::testing
