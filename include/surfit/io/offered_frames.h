#pragma once

#include <memory>

#include "surfit/io/frame_source.h"

namespace surfit {

// The frames of a recording as a camera offers them. As a camera's need no decoding, all are read
// before the first is offered, with the first call of Next(); a frame takes 7 bytes a pixel. Each
// further one is offered 1 / frames_per_second after the one before, whatever its stamp says, and
// Next() waits for it. Of frames that wait to be taken the newest `capacity` are kept: older ones
// are gone, which is logged, and counted in the ReadResult of the next. Which ones are gone depends
// on how fast frames are taken; as long as none is they are the source's, in their order.
// Throws InputError unless frames_per_second is positive and capacity at least 1.
std::unique_ptr<FrameSource> OfferFrames(std::unique_ptr<FrameSource> source,
                                         double frames_per_second, int capacity);

}  // namespace surfit
