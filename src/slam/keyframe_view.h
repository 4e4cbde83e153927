#pragma once

#include "surfit/loop_closure/keyframe.h"
#include "surfit/slam/backend.h"

namespace surfit {

// The view of a keyframe, to be made when it is asked for first.
ViewOfKeyframe ViewOf(ColoredView source, const PlaceViewOptions& options);

}  // namespace surfit
