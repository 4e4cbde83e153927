#pragma once

#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/loop_closure.h"

namespace surfit {

// The view of a keyframe, to be made when it is asked for first.
ViewOfKeyframe ViewOf(ColoredView source, const PlaceViewOptions& options);

}  // namespace surfit
