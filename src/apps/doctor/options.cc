#include "surfit/core/options.h"

#include "apps/doctor/check_recording.h"
#include "core/shared_options.h"

namespace surfit {

void RecordingCheckOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "what to read");
  v.Group("run");
  v.Add(track, "track",
        "track the camera, which tells of its calibration and of the latency of colour", AsFlag(),
        Everyday());
  v.Add(threads, SharedOption("threads", Everyday()));
}

}  // namespace surfit
