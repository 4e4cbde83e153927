#pragma once

#include <optional>

#include "slam/tracker.h"
#include "surfit/slam/slam.h"

namespace surfit {

// What became of a frame, but for what belongs to frames beside it.
FrameReport Report(const RgbdFrame& frame, const Tracked& tracked,
                   const std::optional<FusionReport>& fused, const StageTimes& times);

}  // namespace surfit
