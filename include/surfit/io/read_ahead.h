#pragma once

#include <memory>

#include "surfit/io/frame_source.h"

namespace surfit {

// The same frames in the same order, read by a background task while the caller works, up to
// `capacity` of them ahead. With one thread (ThreadLimit) they are read when asked for. An
// exception of the source is thrown by Next() in its turn, and then the sequence is over.
// Throws InputError unless capacity is at least 1.
std::unique_ptr<FrameSource> ReadAhead(std::unique_ptr<FrameSource> source, int capacity);

}  // namespace surfit
