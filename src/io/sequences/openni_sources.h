#pragma once

#include <atomic>
#include <functional>

#include "io/sequences/raw_frames.h"
#include "io/sequences/recording.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/sequence.h"

namespace surfit {

// OpenNI2's cameras and recordings, without its headers. All throw InputError naming the device or
// file, also where this was built without OpenNI2.

struct OniFile {
  OpenedRecording recording;
  std::function<RgbdCamera()> camera;  // by the field of view; good as long as the recording
};

OniFile OpenOni(const SequenceOptions& options);

// The camera that options.path names, see OpenLive().
RawSequence OpenOpenNiCamera(const SequenceOptions& options, int capacity,
                             const std::atomic<bool>& stop);

}  // namespace surfit
