#include "common/recorded_flags.h"

#include <gflags/gflags.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "surfit/core/error.h"

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

}  // namespace

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

}  // namespace surfit::tools
