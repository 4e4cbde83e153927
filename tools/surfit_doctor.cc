// Checks a recording for faults.

#include <iostream>

#include "apps/doctor/check_recording.h"
#include "common/console.h"
#include "common/json.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string summary;
  RecordingCheckOptions check;

  void Visit(OptionVisitor& v) {
    v.AddPart(check, "check", "checks");
    v.Group("run");
    v.Add(summary, SharedOption("summary", Everyday()));
  }
};

void PrintTable(const RecordingReport& report) {
  std::vector<std::vector<std::string>> rows = {{"", "check", "measured", "must be"}};
  for (const RecordingCheck& check : report.checks) {
    const auto with_unit = [&](const std::string& text) {
      return check.unit.empty() ? text : text + " " + check.unit;
    };
    rows.push_back({check.IsSound() ? "" : "FAULT", check.name,
                    check.value ? with_unit(Number(*check.value, 3)) : "-", check.constraint});
  }
  std::cout << TextTable(rows, 3);
}

void PrintFaults(const RecordingReport& report) {
  if (report.interrupted) {
    std::cout << "interrupted: only the first " << report.frames << " frames were checked\n";
  }
  if (report.IsSound()) std::cout << "no fault in " << report.frames << " frames\n";
  for (const RecordingCheck& check : report.checks) {
    if (!check.IsSound()) {
      std::cout << "\n"
                << check.name << ": " << check.fault << ".\n  Remedy: " << check.advice << ".\n";
    }
  }
  std::cout << std::flush;
}

Json ToJson(const RecordingReport& report, Options options) {
  Json json = {{"format", report.info.format}, {"camera_from", report.info.camera_from},
               {"frames", report.frames},      {"interrupted", report.interrupted},
               {"is_sound", report.IsSound()}, {"checks", Json::array()}};
  for (const RecordingCheck& check : report.checks) {
    json["checks"].push_back({{"name", check.name},
                              {"value", check.value ? Json(*check.value) : Json()},
                              {"unit", check.unit},
                              {"must_be", check.constraint},
                              {"is_sound", check.IsSound()},
                              {"fault", check.fault},
                              {"advice", check.advice}});
  }
  json["warnings"] = report.info.warnings;
  json["options"] = FlagsToJson(TableOf(&options));
  return json;
}

int Run(const Options& options) {
  ProgressLine line;
  int seen = 0;
  const RecordingReport report =
      CheckRecording(options.check, CatchInterruptions(), [&](int frames) {
        seen = frames;
        line.Show(Concat("frame ", frames), /*last=*/false);
      });
  line.Show(Concat("frame ", seen), /*last=*/true);
  PrintTable(report);
  PrintFaults(report);
  if (!options.summary.empty()) {
    WriteFileAtomically(options.summary,
                        [&](std::ostream& out) { out << ToText(ToJson(report, options)); });
  }
  return report.IsSound() ? kDone : kFaultsFound;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "checks an RGB-D recording, and prints faults and remedies: depth scale, colour "
      "registration and latency, exposure, blur, missing frames, calibration, ratio and range of "
      "valid depth.",
      surfit::tools::Run);
}
