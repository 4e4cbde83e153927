#pragma once

#include "surfit/slam/slam.h"
#include "tracking/tracked.h"

namespace surfit {

// Report of a tracked frame, without fusion and times.
FrameReport ReportOf(const RgbdFrame& frame, const Tracked& tracked);

}  // namespace surfit
