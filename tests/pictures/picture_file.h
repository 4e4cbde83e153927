#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>

#include "surfit/core/image.h"
#include "testing/pixels.h"

namespace surfit::testing {

// Pixels of a PNG file. Adds a test failure and returns an empty image if it cannot be read.
inline Image<Rgb8> ReadPicture(const std::string& path) {
  const cv::Mat bgr = cv::imread(path, cv::IMREAD_COLOR);
  if (bgr.empty()) ADD_FAILURE() << path << " is no picture";
  Image<Rgb8> image(bgr.cols, bgr.rows);
  for (const auto [u, v] : PixelsOf(bgr.cols, bgr.rows)) {
    const auto& pixel = bgr.at<cv::Vec3b>(v, u);
    image(u, v) = {pixel[2], pixel[1], pixel[0]};
  }
  return image;
}

inline std::size_t CountColors(const Image<Rgb8>& image) {
  std::set<int> colors;
  for (const Rgb8 c : image) colors.insert(c.r << 16 | c.g << 8 | c.b);
  return colors.size();
}

inline std::size_t CountPixels(const Image<Rgb8>& image, Rgb8 color) {
  return std::count(image.begin(), image.end(), color);
}

}  // namespace surfit::testing
