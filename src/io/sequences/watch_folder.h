#pragma once

#include <atomic>

#include "io/sequences/raw_frames.h"
#include "surfit/io/sequence.h"

namespace surfit {

// What WatchFolder() reads, before it is prepared. The options are valid.
RawSequence OpenWatchedFolder(const SequenceOptions& options, const std::atomic<bool>& stop);

}  // namespace surfit
