#pragma once

#include <atomic>

#include "io/sequences/raw_frames.h"
#include "io/sequences/recording.h"

namespace surfit {

// OpenNI2's cameras and recordings, without its headers. All throw InputError naming the device or
// file, also where this was built without OpenNI2.

// Its camera is told by the field of view.
OpenedRecording OpenOni(const SequenceOptions& options);

// The camera that options.path names, see OpenLive().
RawSequence OpenOpenNiCamera(const SequenceOptions& options, int capacity,
                             const std::atomic<bool>& stop);

}  // namespace surfit
