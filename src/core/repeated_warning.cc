#include "core/repeated_warning.h"

#include <glog/logging.h>

#include <utility>

namespace surfit {
namespace {

constexpr int kTold = 3;

}  // namespace

RepeatedWarning::RepeatedWarning(std::string what) : what_(std::move(what)) {}

RepeatedWarning::~RepeatedWarning() {
  if (count_ > kTold) LOG(WARNING) << "and " << count_ - kTold << " more " << what_;
}

void RepeatedWarning::Tell(const std::string& text) {
  if (++count_ <= kTold) LOG(WARNING) << text;
}

}  // namespace surfit
