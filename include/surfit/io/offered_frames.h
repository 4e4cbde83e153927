#pragma once

#include <memory>

#include "surfit/io/frame_source.h"

namespace surfit {

// Offers the frames of a recording at a fixed rate, as a live camera does. All frames are read by
// the first call of Next(), so that decoding costs no time later; a frame takes 7 bytes a pixel.
// Frame i is offered i / frames_per_second after the first, whatever its stamp says, and Next()
// waits for it. A queue keeps the newest `capacity` frames that were offered and not yet taken.
// Older ones are dropped, logged, and counted in the next ReadResult. Which frames are dropped
// depends on how fast they are taken; if none is, they are the source's, in order. Throws
// InputError unless frames_per_second is positive and capacity at least 1.
std::unique_ptr<FrameSource> OfferFrames(std::unique_ptr<FrameSource> source,
                                         double frames_per_second, int capacity);

}  // namespace surfit
