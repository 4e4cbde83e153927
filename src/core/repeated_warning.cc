#include "core/repeated_warning.h"

#include <glog/logging.h>

#include <utility>

namespace surfit {
namespace {

constexpr int kMaxLogged = 3;

}  // namespace

RepeatedWarning::RepeatedWarning(std::string what) : what_(std::move(what)) {}

RepeatedWarning::~RepeatedWarning() {
  if (count_ > kMaxLogged) LOG(WARNING) << "and " << count_ - kMaxLogged << " more " << what_;
}

void RepeatedWarning::Tell(const std::string& text) {
  if (++count_ <= kMaxLogged) LOG(WARNING) << text;
}

}  // namespace surfit
