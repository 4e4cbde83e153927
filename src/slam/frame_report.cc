#include "slam/frame_report.h"

namespace surfit {

FrameReport ReportOf(const RgbdFrame& frame, const Tracked& tracked) {
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
  return report;
}

}  // namespace surfit
