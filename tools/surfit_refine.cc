// Refines a run of surfit_slam: poses, surfels and the camera's calibration, all at once.

#include <gflags/gflags.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/outcomes.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/run/refine_run.h"

namespace surfit::tools {
namespace {

nlohmann::json OptionsIn(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw InputError(path + " cannot be read");
  const nlohmann::json json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("options") || !json["options"].is_object()) {
    throw InputError(path + " is no summary of a run: it has no options");
  }
  return json["options"];
}

// Gives each flag of these options the value that a run's summary.json has recorded for it, unless
// the command line has set it. Throws InputError naming the file if it cannot be read or tells no
// such options, and the flag whose value does not fit.
void TakeRecordedFlags(const std::string& summary_json, const OptionTable& options) {
  const nlohmann::json recorded = OptionsIn(summary_json);
  for (const auto& [name, present] : TableFlags(options)) {
    const gflags::CommandLineFlagInfo flag = gflags::GetCommandLineFlagInfoOrDie(name.c_str());
    if (!flag.is_default || !recorded.contains(name)) continue;
    const nlohmann::json& value = recorded[name];
    if (!value.is_string() ||
        gflags::SetCommandLineOption(name.c_str(), value.get<std::string>().c_str()).empty()) {
      throw InputError(Concat(summary_json, ": options: ", name, " is ", value.dump(), ", which --",
                              name, " does not take"));
    }
  }
}

struct Options {
  std::string run;
  RefineRunOptions refine;

  void Visit(OptionVisitor& v) {
    v.Group("run");
    v.Add(run, "run",
          "output folder of surfit_slam; its summary.json says which sequence it read and how, "
          "where flags do not",
          Everyday());
    v.AddPart(refine, "refine", "how it is refined");
  }
  void TakeWhatTheRunRead() {
    RequireFlag("run", run);
    TakeRecordedFlags(run + "/summary.json", TableOf(&refine.sequence));
    refine.trajectory = run + "/trajectory.txt";
    refine.output = run + "/refined";
  }
};

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::Options options;
  return surfit::tools::ToolMain(
      argc, argv,
      "refines a run of surfit_slam: the poses of keyframes, the surfels that they share and the "
      "camera's calibration by joint least squares; moves the other poses along and fuses the map "
      "anew.",
      surfit::TableOf(&options), [&] { return surfit::tools::RefineAndPrint(options.refine); },
      [&] { options.TakeWhatTheRunRead(); });
}
