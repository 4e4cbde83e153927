#include "slam/frame_report.h"

namespace surfit {

std::string ToString(FrameState state) {
  switch (state) {
    case FrameState::kFirst:
      return "first";
    case FrameState::kTracked:
      return "tracked";
    case FrameState::kDegenerate:
      return "degenerate";
    case FrameState::kFrozen:
      return "frozen";
    case FrameState::kGiven:
      return "given";
    case FrameState::kLost:
      return "lost";
    case FrameState::kRelocalized:
      return "relocalised";
    case FrameState::kNewMap:
      return "new_map";
  }
  return "unknown";
}

FrameReport Report(const RgbdFrame& frame, const Tracked& tracked,
                   const std::optional<FusionReport>& fused, const StageTimes& times) {
  FrameReport report;
  report.index = frame.index;
  report.stamp_s = frame.stamp_s;
  report.state = tracked.state;
  report.world_from_camera = tracked.world_from_camera;
  report.found_again = tracked.found_again;
  report.has_own_view = tracked.has_own_view;
  report.moving_share = tracked.moving_share;
  report.is_apart = tracked.is_apart;
  report.moving = tracked.moving;
  report.icp = tracked.icp;
  report.is_fused = fused.has_value();
  if (fused) report.fusion = *fused;
  report.times = times;
  return report;
}

}  // namespace surfit
