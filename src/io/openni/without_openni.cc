// What stands in for io/openni where OpenNI2's headers are missing.
#include "io/sequences/raw_frames.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

[[noreturn]] void Refuse(const SequenceOptions& options) {
  throw InputError(
      options.path,
      ": this build of Surfit has no OpenNI2; build it where Debian's libopenni2-dev is installed");
}

}  // namespace

OpenedRecording OpenOni(const SequenceOptions& options) { Refuse(options); }

RawSequence OpenOpenNiCamera(const SequenceOptions& options, int /*capacity*/,
                             const std::atomic<bool>& /*stop*/) {
  Refuse(options);
}

}  // namespace surfit
