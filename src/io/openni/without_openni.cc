// Replacement of io/openni for builds without the OpenNI2 headers.
#include "io/sequences/raw_frames.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

[[noreturn]] void Refuse(const SequenceOptions& options) {
  throw InputError(options.path,
                   ": this build of Surfit has no OpenNI2: install the Debian package "
                   "libopenni2-dev and rebuild");
}

}  // namespace

OpenedRecording OpenOni(const SequenceOptions& options) { Refuse(options); }

RawSequence OpenOpenNiCamera(const SequenceOptions& options, int /*capacity*/,
                             const std::atomic<bool>& /*stop*/) {
  Refuse(options);
}

}  // namespace surfit
