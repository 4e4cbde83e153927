// Records a camera or another sequence as a folder in TUM format.

#include <atomic>
#include <cstdio>

#include "common/console.h"
#include "common/tool_main.h"
#include "io/sequences/record.h"

namespace surfit::tools {
namespace {

void ShowProgress(const RecordSummary& now) {
  static ProgressLine line;
  char text[160];
  std::snprintf(text, sizeof(text), "%d frames, %.1f s  %.0f MB  %d skipped, %d dropped",
                now.frames_written, now.seconds, 1e-6 * static_cast<double>(now.bytes),
                now.frames_skipped, now.frames_dropped);
  line.Show(text, false);
}

void PrintSummary(const RecordSummary& s, const std::string& output) {
  std::printf("%s: %d frames over %.2f s, %d skipped, %d dropped%s\n", output.c_str(),
              s.frames_written, s.seconds, s.frames_skipped, s.frames_dropped,
              s.interrupted ? ", interrupted" : "");
  if (s.pauses > 0) std::printf("the camera was disconnected %d times\n", s.pauses);
  if (s.depths > 0) {
    std::printf(
        "%.1f %% of depth has low confidence and is written as missing; confidence images "
        "are not written\n",
        100 * static_cast<double>(s.low_confidence) / static_cast<double>(s.depths));
  }
  if (s.depth_is_rounded) {
    std::printf("depth in metres was rounded to 0.2 mm; %lld depths above 13.1 m were removed\n",
                static_cast<long long>(s.depths_out_of_range));
  }
}

int Run(const RecordOptions& options) {
  const std::atomic<bool>& interrupted = CatchInterruptions();
  const RecordSummary summary = RecordSequence(options, interrupted, ShowProgress);
  std::fputc('\n', stderr);  // ends the progress line
  PrintSummary(summary, options.output);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "records a camera or another sequence as a folder in TUM format, "
                                 "without loss",
                                 surfit::tools::Run);
}
