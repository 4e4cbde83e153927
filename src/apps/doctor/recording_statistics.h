#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/sequences/raw_frames.h"
#include "surfit/core/image.h"

namespace surfit {

struct ColorStatistics {
  double brightness = 0;             // the mean, from 0 to 1
  double saturated_ratio = 0;        // ratio of saturated pixels
  std::optional<double> edge_width;  // EdgeWidth()
};

struct FrameStatistics {
  int index = 0;
  FrameStamps stamps;
  std::string error;          // read error; if not empty, the members below are unset
  double valid_ratio = 0;     // ratio of pixels with depth
  double median_depth_m = 0;  // median of the valid depth; 0: no valid depth
  bool repeats_depth = false, repeats_color = false;  // bitwise identical to the previous frame
  std::optional<ColorStatistics> color;
};

// Width of the edges relative to the image width: the larger of the widths along rows and along
// columns, because motion blur has one direction. An edge of height h and width w has differences
// of h / w between pixels. Averaging over n pixels reduces them to h / n, so the remaining ratio
// w/n gives the width (after Crete et al., SPIE 2007).
// Returns std::nullopt if the image has too few edges above the noise.
std::optional<double> EdgeWidth(const Image<Rgb8>& color);

// Collects statistics of a recording, frame by frame.
class RecordingStatistics {
 public:
  // Raw depth images are integers in units of 1 / depth_units_per_metre, or floats in metres.
  explicit RecordingStatistics(double depth_units_per_metre)
      : depth_units_per_metre_(depth_units_per_metre) {}

  // Adds a readable frame. `depth_m` is the prepared depth.
  void Add(int index, const FrameStamps& stamps, const FrameImages& images,
           const Image<float>& depth_m);
  void AddUnreadable(int index, const FrameStamps& stamps, const std::string& error);

  const std::vector<FrameStatistics>& frames() const { return frames_; }
  // Median difference of the inverses of adjacent depth values of the sensor, 1/m. Returns
  // std::nullopt for float depth, and for fewer than 30 depth steps of the sensor.
  std::optional<double> InverseDepthStep() const;

 private:
  void CountDepths(const RawDepth& depth);

  double depth_units_per_metre_;
  std::vector<FrameStatistics> frames_;
  FrameImages last_;
  std::vector<std::uint32_t> pixels_of_count_;  // per raw depth value
};

}  // namespace surfit
