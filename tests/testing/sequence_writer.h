#pragma once

#include <cstdint>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/sequence.h"
#include "testing/temp_folder.h"

namespace surfit::testing {

// Writes an image file. The extension determines the format.
inline void WriteDepth(const std::string& path, const Image<std::uint16_t>& raw) {
  cv::imwrite(path,
              cv::Mat(raw.height(), raw.width(), CV_16UC1, const_cast<std::uint16_t*>(raw.data())));
}

inline void WriteDepth(const std::string& path, const Image<float>& metres) {
  cv::imwrite(
      path, cv::Mat(metres.height(), metres.width(), CV_32FC1, const_cast<float*>(metres.data())));
}

inline void WriteConfidence(const std::string& path, const Image<std::uint8_t>& confidence,
                            const std::vector<int>& parameters = {}) {
  cv::imwrite(path,
              cv::Mat(confidence.height(), confidence.width(), CV_8UC1,
                      const_cast<std::uint8_t*>(confidence.data())),
              parameters);
}

inline void WriteColor(const std::string& path, const Image<Rgb8>& color,
                       const std::vector<int>& parameters = {}) {
  cv::Mat bgr(color.height(), color.width(), CV_8UC3);
  for (std::size_t i = 0; i < color.size(); ++i)
    bgr.at<cv::Vec3b>(static_cast<int>(i)) = {color[i].b, color[i].g, color[i].r};
  cv::imwrite(path, bgr, parameters);
}

// Default options for the sequence at `path`.
inline SequenceOptions OptionsOf(const std::string& path) {
  SequenceOptions options;
  options.path = path;
  return options;
}
inline SequenceOptions Options(const TempFolder& folder) { return OptionsOf(folder.path()); }

// Small images that encode the frame number: depth is 1000 counts plus 10 per frame and up to 6 per
// pixel, and red is the frame number.
inline Image<std::uint16_t> NumberedDepth(int frame, int width = 32, int height = 24) {
  Image<std::uint16_t> depth(width, height);
  for (std::size_t i = 0; i < depth.size(); ++i)
    depth[i] = static_cast<std::uint16_t>(1000 + 10 * frame + i % 7);
  return depth;
}

inline Image<Rgb8> NumberedColor(int frame, int width = 32, int height = 24) {
  return Image<Rgb8>(width, height, {static_cast<std::uint8_t>(frame), 20, 30});
}

inline std::string Format(const char* format, int number) {
  char text[100];
  std::snprintf(text, sizeof(text), format, number);
  return text;
}

// camera.yaml for these images.
inline std::string SmallCameraYaml(double fy = 30) {
  return "%YAML:1.0\n---\ndepth_camera: { width: 32, height: 24, fx: 31., fy: " +
         std::to_string(fy) +
         ", cx: 15.5, cy: 11.5 }\ndepth_units_per_metre: 1000.\nframes_per_second: 30.\n";
}

// Writes a TUM folder with camera.yaml and `count` frames at 10 Hz, starting at 5 s. Depth is 3 ms
// later than colour. The pose of frame i is the translation (i, 2, 3).
inline void WriteTumSequence(const TempFolder& folder, int count, double fy = 30) {
  std::string rgb = "# colour\n", depth = "# depth\n", poses = "# poses\n";
  for (int i = 0; i < count; ++i) {
    const std::string color_name = Format("rgb/%03d.png", i),
                      depth_name = Format("depth/%03d.png", i);
    WriteColor(folder / color_name, NumberedColor(i));
    WriteDepth(folder / depth_name, NumberedDepth(i));
    rgb += std::to_string(5 + 0.1 * i) + " " + color_name + "\n";
    depth += std::to_string(5.003 + 0.1 * i) + " " + depth_name + "\n";
    poses += std::to_string(5 + 0.1 * i) + Format(" %d 2 3 0.6 0 0 0.8\n", i);
  }
  folder.Write("rgb.txt", rgb);
  folder.Write("depth.txt", depth);
  folder.Write("groundtruth.txt", poses);
  folder.Write("camera.yaml", SmallCameraYaml(fy));
}

inline std::vector<ReadResult> ReadAll(FrameSource* source) {
  std::vector<ReadResult> results;
  while (auto result = source->Next()) results.push_back(std::move(*result));
  return results;
}

}  // namespace surfit::testing
