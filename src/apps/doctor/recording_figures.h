#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/sequences/raw_frames.h"
#include "surfit/core/image.h"

namespace surfit {

// What the colours of a frame are like.
struct ColorFigures {
  double brightness = 0;             // the mean, from 0 to 1
  double saturated_share = 0;        // of the pixels, those as bright as can be
  std::optional<double> edge_width;  // EdgeWidth()
};

// What a frame is like, as it was recorded.
struct FrameFigures {
  int index = 0;
  FrameStamps stamps;
  std::string error;          // why it could not be read; then nothing follows
  double valid_share = 0;     // of the pixels, those with depth
  double median_depth_m = 0;  // of these; 0 without any
  bool repeats_depth = false, repeats_color = false;  // the last frame's, to the last bit
  std::optional<ColorFigures> color;
};

// How wide the edges are along rows or along columns, whichever is more, for motion blurs along one
// direction. An edge of height h that is w pixels wide has differences of h / w there; once the
// image is averaged over n pixels they are h / n, and the share that is left, w / n, tells w (after
// Crete et al., SPIE 2007). As a share of the image's width. Nothing where there are too few edges
// that are more than noise.
std::optional<double> EdgeWidth(const Image<Rgb8>& color);

// Looks at frames one after the other.
class RecordingFigures {
 public:
  // Depth images are counts of 1 / depth_units_per_metre, or metres.
  explicit RecordingFigures(double depth_units_per_metre)
      : depth_units_per_metre_(depth_units_per_metre) {}

  // A frame whose images could be read, with its depth as it is used.
  void Add(int index, const FrameStamps& stamps, const FrameImages& images,
           const Image<float>& depth_m);
  void AddUnreadable(int index, const FrameStamps& stamps, const std::string& error);

  const std::vector<FrameFigures>& frames() const { return frames_; }
  // By how much the inverses of neighbouring depths differ where the sensor has no others between
  // them, in 1/m: the median. Nothing where depth is finer than its counts.
  std::optional<double> InverseDepthStep() const;

 private:
  void CountDepths(const RawDepth& depth);

  double depth_units_per_metre_;
  std::vector<FrameFigures> frames_;
  FrameImages last_;
  std::vector<std::uint32_t> pixels_of_count_;  // of all frames
};

}  // namespace surfit
