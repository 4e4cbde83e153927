#include "places/expanded_view.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace surfit {
namespace {

BrightnessLevel BrightnessOfLevel(const FrameLevel& level) {
  Image<float> value(level.camera.width, level.camera.height);
  for (std::size_t i = 0; i < level.intensity.size(); ++i) {
    value[i] = level.intensity[i] >= 0 ? level.intensity[i] : 0;
  }
  return BrightnessOf(std::move(value));
}

}  // namespace

ExpandedView Expand(const PlaceView& view, const PreprocessOptions& preprocess) {
  ExpandedView expanded;
  std::vector<FrameLevel> levels = PyramidOf(view, preprocess).levels;
  if (levels.size() == 1) levels.push_back(levels.front());
  const int last = std::min<int>(static_cast<int>(levels.size()), 1 + ExpandedView::kCoarserLevels);
  expanded.finest.levels.push_back(std::move(levels.front()));
  std::move(levels.begin() + 1, levels.begin() + last, std::back_inserter(expanded.coarser.levels));
  expanded.brightness = BrightnessOfLevel(expanded.coarser.levels.front());
  expanded.has_color = !view.intensity.empty();
  return expanded;
}

}  // namespace surfit
