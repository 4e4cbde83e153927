#pragma once

#include <zlib.h>

#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "surfit/core/image.h"

namespace surfit::testing {

// What .klg and .sens files are made of, by other means than the library's.

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

}  // namespace surfit::testing
