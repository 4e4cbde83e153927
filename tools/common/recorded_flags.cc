#include "common/recorded_flags.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "surfit/core/error.h"
#include "surfit/run/slam_run.h"

namespace surfit::tools {
namespace {

// Flags that a camera.yaml replaces.
constexpr std::array kFlagsOfCamera = {"camera", "intrinsics", "depth_scale",
                                       "inverse_depth_sigma"};

bool IsOfCamera(const std::string& flag) {
  return std::find(kFlagsOfCamera.begin(), kFlagsOfCamera.end(), flag) != kFlagsOfCamera.end();
}

// Path of the calibrated camera of a run; empty if there is none.
std::string FoundCamera(const std::string& run) {
  const std::string path = run + "/camera.yaml";
  return std::filesystem::is_regular_file(path) ? path : "";
}

// Former flags of fields of SequenceOptions with another name.
const std::map<std::string, std::string>& FormerFlags() {
  static const std::map<std::string, std::string> kFlags = {{"frames_per_second", "fps"}};
  return kFlags;
}

// Sets texts without a flag to their recorded values.
class RecordedTexts final : public OptionVisitor {
 public:
  RecordedTexts(const std::map<std::string, std::string>& recorded, std::string summary_json)
      : recorded_(recorded), summary_json_(std::move(summary_json)) {}

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    auto* const* const text = std::get_if<OptionText*>(&value);
    if (text == nullptr || !option.flag.empty()) return;
    const auto former = FormerFlags().find(option.name);
    const std::string old_flag = former == FormerFlags().end() ? option.name : former->second;
    for (const std::string& name : {"sequence." + option.name, old_flag}) {
      const auto found = recorded_.find(name);
      if (found == recorded_.end()) continue;
      SetText(summary_json_ + ": options: " + name, found->second, *text);
      return;
    }
  }

  const std::map<std::string, std::string>& recorded_;
  std::string summary_json_;
};

// Runs of version 0.1 have one flag per topic of a ROS bag.
std::map<std::string, std::string> WithTopics(std::map<std::string, std::string> recorded) {
  if (recorded.count("topics") > 0) return recorded;
  const std::string depth = recorded["depth_topic"], color = recorded["color_topic"];
  if (!depth.empty() || !color.empty()) recorded["topics"] = depth + "," + color;
  return recorded;
}

// True if the program has the flag and the command line does not set it.
bool IsDefault(const std::string& name) {
  gflags::CommandLineFlagInfo flag;
  return gflags::GetCommandLineFlagInfo(name.c_str(), &flag) && flag.is_default;
}

}  // namespace

void ApplyRecordedFlags(const std::string& run, const OptionTable& sequence,
                        const std::set<std::string>& left_out, RecordedCamera wanted) {
  const std::string summary_json = run + "/summary.json";
  const std::map<std::string, std::string> recorded = WithTopics(RecordedFlags(summary_json));
  const bool wants_found = wanted == RecordedCamera::kFound && IsDefault("camera");
  const std::string camera = wants_found ? FoundCamera(run) : "";
  for (const auto& [name, present] : TableFlags(sequence)) {
    const auto value = recorded.find(name);
    if (!IsDefault(name) || value == recorded.end() || left_out.count(name) > 0) continue;
    if (!camera.empty() && IsOfCamera(name)) continue;
    if (gflags::SetCommandLineOption(name.c_str(), value->second.c_str()).empty()) {
      throw InputError(Concat(summary_json, ": options: ", name, " is '", value->second,
                              "', which --", name, " does not accept"));
    }
  }
  if (!camera.empty()) {
    gflags::SetCommandLineOption("camera", camera.c_str());
  } else {
    RecordedTexts texts(recorded, summary_json);
    sequence(texts);
  }
}

}  // namespace surfit::tools
