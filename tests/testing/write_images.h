#pragma once

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "surfit/core/image.h"

namespace surfit::testing {

// Image files for the readers to read, of the kind that the name's ending says.
inline void WriteDepth(const std::string& path, const Image<std::uint16_t>& raw) {
  cv::imwrite(path,
              cv::Mat(raw.height(), raw.width(), CV_16UC1, const_cast<std::uint16_t*>(raw.data())));
}

inline void WriteDepth(const std::string& path, const Image<float>& metres) {
  cv::imwrite(
      path, cv::Mat(metres.height(), metres.width(), CV_32FC1, const_cast<float*>(metres.data())));
}

inline void WriteColor(const std::string& path, const Image<Rgb8>& color,
                       const std::vector<int>& parameters = {}) {
  cv::Mat bgr(color.height(), color.width(), CV_8UC3);
  for (std::size_t i = 0; i < color.size(); ++i)
    bgr.at<cv::Vec3b>(static_cast<int>(i)) = {color[i].b, color[i].g, color[i].r};
  cv::imwrite(path, bgr, parameters);
}

}  // namespace surfit::testing
