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

}  // namespace surfit
