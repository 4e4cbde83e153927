#include "common/json.h"

namespace surfit::tools {

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

}  // namespace surfit::tools
