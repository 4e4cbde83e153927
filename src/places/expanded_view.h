#pragma once

#include "registration/view_level.h"
#include "surfit/places/keyframe.h"

namespace surfit {

// A view of a place as registration needs it.
struct ExpandedView {
  FramePyramid finest;         // of one level
  FramePyramid coarser;        // of the next kCoarserLevels, or the same as the finest
  BrightnessLevel brightness;  // of the coarser pyramid's first level; zeros where it is unknown
  bool has_color = false;

  static constexpr int kCoarserLevels = 2;

  ViewLevel Level() const { return {coarser.levels.front(), brightness}; }
};

// The view must not be empty.
ExpandedView Expand(const PlaceView& view, const PreprocessOptions& preprocess);

}  // namespace surfit
