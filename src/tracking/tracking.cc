#include "surfit/tracking/tracking.h"

namespace surfit {

std::string ToString(FrameState state) {
  switch (state) {
    case FrameState::kFirst:
      return "first";
    case FrameState::kTracked:
      return "tracked";
    case FrameState::kDegenerate:
      return "degenerate";
    case FrameState::kDuplicate:
      return "duplicate";
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

}  // namespace surfit
