#include "common/json.h"

#include <iostream>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

class FlagWriter final : public OptionVisitor {
 public:
  Json json;

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    if (option.flag.empty()) return;
    const bool is_text =
        std::holds_alternative<std::string*>(value) || std::holds_alternative<OptionText*>(value);
    const std::string text = FlagText(option, value);
    json[option.flag] = is_text ? Json(text) : Json::parse(text);
  }
};

}  // namespace

void SetStatistics(const std::string& prefix, const std::string& unit,
                   const ErrorStatistics* statistics, Json* json) {
  const auto set = [&](const char* name, double ErrorStatistics::*member) {
    Json& value = (*json)[prefix + "_" + name + "_" + unit];
    if (statistics != nullptr) value = statistics->*member;
  };
  set("rmse", &ErrorStatistics::rmse);
  set("mean", &ErrorStatistics::mean);
  set("median", &ErrorStatistics::median);
  set("p90", &ErrorStatistics::p90);
  set("max", &ErrorStatistics::max);
}

Json FlagsToJson(const OptionTable& options) {
  FlagWriter writer;
  options(writer);
  return std::move(writer.json);
}

std::string ToText(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void PrintJson(const Json& json) {
  std::cout << ToText(json) << std::flush;
  if (!std::cout) throw InputError("cannot write to stdout");
}

}  // namespace surfit::tools
