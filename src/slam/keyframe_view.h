#pragma once

#include "surfit/places/keyframe.h"
#include "surfit/slam/backend.h"

namespace surfit {

// The view of a keyframe, to be made when it is asked for first.
ViewOfKeyframe ViewOf(ColoredView source, const PlaceViewOptions& options);

}  // namespace surfit
