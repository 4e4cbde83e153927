// Compares rendered views of the map of a run with its frames.

#include <iostream>

#include "apps/evaluate/view_evaluation.h"
#include "common/console.h"
#include "common/recorded_flags.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "evaluate/evaluations.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

void Print(const ViewEvaluation& evaluation) {
  const ViewError& mean = evaluation.mean;
  std::printf(
      "%zu frames%s: PSNR %.2f dB over covered pixels (%.2f dB with a gain per view and channel, "
      "%.2f dB from poses registered by colour), %.2f dB over all pixels; SSIM %.3f and %.3f; "
      "%.1f %% covered; depth error %.1f mm (median), %.1f mm (mean)\n",
      evaluation.views.size(), evaluation.held_out ? " that are not in the map" : "",
      mean.psnr_covered_db, mean.psnr_covered_by_gain_db, mean.psnr_registered_db, mean.psnr_db,
      mean.ssim_covered, mean.ssim, 100 * mean.coverage, 1000 * mean.depth_error_median_m,
      1000 * mean.depth_error_mean_m);
  if (evaluation.without_color > 0) {
    std::printf("%d frames without colour were skipped\n", evaluation.without_color);
  }
  if (!evaluation.held_out) {
    std::printf("the map contains these frames: set surfit_slam --hold_out=10 to exclude some\n");
  }
  if (!evaluation.worst_view.empty()) std::printf("worst: %s\n", evaluation.worst_view.c_str());
}

struct ViewOptions {
  ViewEvaluationOptions views;
  bool pictures = true;

  void Visit(OptionVisitor& v) {
    v.AddPart(views, "views", "comparison of views");
    v.Add(pictures, SharedOption("pictures"));
  }
};

int RunViews(const ViewOptions& given) {
  ViewEvaluationOptions options = given.views;
  if (!given.pictures) options.pictures = 0;
  ProgressLine line;
  const ViewEvaluation evaluation =
      EvaluateViews(options, [&](int views) { line.Show(Concat("view ", views), false); });
  line.Show(Concat("view ", evaluation.views.size()), true);
  Print(evaluation);
  return kDone;
}

// The calibrated camera is in poses.json of the run, so the frames are read with the input camera.
void PrepareViews(ViewOptions* options) {
  const std::string& run = options->views.run;
  RequireFlag("run", run);
  ApplyRecordedFlags(run, TableOf(&options->views.sequence), {}, RecordedCamera::kGiven);
}

}  // namespace

Mode ViewEvaluationMode() { return MakeMode("views", RunViews, PrepareViews); }

}  // namespace surfit::tools
