#include "surfit/core/options.h"

#include "apps/evaluate/revisits.h"
#include "apps/evaluate/view_evaluation.h"
#include "core/shared_options.h"
#include "output/recorded_run.h"

namespace surfit {

void RevisitOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "input sequence", WithoutFlags({"first", "last"}));
  v.Group("revisits");
  v.Add(estimate, SharedOption("estimate", Required(), Everyday()));
  v.Add(min_gap, "min_gap", "minimum number of frames between two visits", AtLeast(1),
        AsFlag("revisit_gap"), Everyday());
  v.Add(max_distance_m, "max_distance_m", "maximum distance between the cameras of two visits",
        Positive());
  v.Add(max_angle_rad, "max_angle_rad", "maximum angle between the cameras of two visits",
        Positive());
  v.AddPart(preprocess, "preprocess", "depth preprocessing", NoFlags());
}

void ViewEvaluationOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "sequence of the run, with the same options");
  v.Group("views");
  v.Add(run, SharedOption("run", Required(), Everyday()));
  v.Add(output, SharedOption("output", Everyday()));
  v.Add(every, "every",
        "evaluate every n-th frame with a pose; for a run with --hold_out: all held-out frames",
        AtLeast(1), Everyday());
  v.Add(pictures, "pictures", "number of pictures, worst views first",
        Between(0, kMaxViewPictures));
  v.Add(threads, SharedOption("threads", Everyday()));
}

}  // namespace surfit
