#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "apps/export/export_run.h"
#include "output/output_files.h"
#include "surfit/core/error.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// What an export reports: progress, messages, and the values of export.json.
class ExportLog {
 public:
  // Keeps the reference. `progress` must not be empty.
  explicit ExportLog(const std::function<void(const std::string&)>& progress)
      : progress_(progress) {}

  template <typename... Parts>
  void Progress(const Parts&... parts) {
    progress_(Concat(parts...));
  }
  template <typename... Parts>
  void Say(const Parts&... parts) {
    summary.messages.push_back(Concat(parts...));
  }
  template <typename... Parts>
  void Warn(const Parts&... parts) {
    summary.warnings.push_back(Concat(parts...));
  }

  Json json;  // export.json
  ExportSummary summary;

 private:
  const std::function<void(const std::string&)>& progress_;
};

// "1.25 degrees".
inline std::string DegreesText(double rad) {
  return Concat(std::round(100 * rad / kRadPerDeg) / 100, " degrees");
}

}  // namespace surfit
