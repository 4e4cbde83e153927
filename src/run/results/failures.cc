#include "run/results/failures.h"

#include <algorithm>
#include <exception>
#include <new>

namespace surfit {
namespace {

constexpr std::size_t kReserve = 32 << 20;  // bytes

}  // namespace

Failures::Failures() { reserve_.reserve(kReserve); }

std::string Failures::text() const {
  std::string text;
  for (const std::string& failure : all_) text += (text.empty() ? "" : "; ") + failure;
  return text;
}

void Failures::AddCurrent() {
  std::string what = "unknown";
  try {
    throw;
  } catch (const std::bad_alloc&) {
    reserve_ = std::vector<char>();
    what = "out of memory: set max_map_points to limit the map";
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {  // keeps "unknown"
  }
  if (std::find(all_.begin(), all_.end(), what) == all_.end()) all_.push_back(what);
}

}  // namespace surfit
