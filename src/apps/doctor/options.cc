#include "surfit/core/options.h"

#include "apps/doctor/check_recording.h"
#include "core/shared_options.h"

namespace surfit {

void RecordingCheckOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "recording to check");
  v.Group("run");
  v.Add(track, "track", "track the camera to check its calibration and the colour latency",
        AsFlag(), Everyday());
  v.Add(threads, SharedOption("threads", Everyday()));
}

}  // namespace surfit
