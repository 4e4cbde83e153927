#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/sequences/raw_frames.h"
#include "surfit/core/image.h"

namespace surfit {

// A pixel is saturated if all channels are at least 250.
struct ColorStatistics {
  double brightness = 0;             // mean, in [0, 1]
  double saturated_ratio = 0;        // saturated pixels / pixels
  std::optional<double> edge_width;  // EdgeWidth(); std::nullopt: too few edges
};

struct FrameStatistics {
  int index = 0;
  FrameStamps stamps;         // s, as recorded
  std::string error;          // read error; if not empty, the following members are unset
  double valid_ratio = 0;     // pixels with depth / pixels
  double median_depth_m = 0;  // over valid pixels; 0: no valid pixel
  bool repeats_depth = false,
       repeats_color = false;            // bitwise identical to the last readable frame
  std::optional<ColorStatistics> color;  // std::nullopt: no colour
};

// Typical width of edges, divided by the image width (after Crete et al., SPIE 2007). Uses the
// larger width of both directions, because motion blur has one direction. Averaging over n pixels
// reduces the slope of an edge of width w by the factor w / n. Returns std::nullopt if the image
// has too few edges above the noise.
std::optional<double> EdgeWidth(const Image<Rgb8>& color);

// Add frames in order. Not thread-safe.
class RecordingStatistics {
 public:
  // `depth_units_per_metre`: unit of integer depth images. Float images are in metres.
  explicit RecordingStatistics(double depth_units_per_metre)
      : depth_units_per_metre_(depth_units_per_metre) {}

  // `images`: raw images. `depth_m`: depth after undistortion and scaling.
  void Add(int index, const FrameStamps& stamps, const FrameImages& images,
           const Image<float>& depth_m);
  // Adds a frame that cannot be read. `error` must not be empty.
  void AddUnreadable(int index, const FrameStamps& stamps, const std::string& error);

  const std::vector<FrameStatistics>& frames() const { return frames_; }
  // Median step of inverse depth between adjacent depth values of the sensor, 1/m. Steps below four
  // raw counts are rounding of the file and are ignored. Returns std::nullopt for float depth, and
  // for fewer than 30 steps.
  std::optional<double> InverseDepthStep() const;

 private:
  void CountDepths(const RawDepth& depth);

  double depth_units_per_metre_;
  std::vector<FrameStatistics> frames_;
  FrameImages last_;
  std::vector<std::uint32_t> pixels_of_count_;
};

}  // namespace surfit
