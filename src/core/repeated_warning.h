#pragma once

#include <string>

namespace surfit {

// Logs the first three occurrences of a warning. The destructor logs the number of others. Not
// thread-safe.
class RepeatedWarning {
 public:
  // `what`: plural noun for the final count, e.g. "frames skipped".
  explicit RepeatedWarning(std::string what);
  ~RepeatedWarning();
  RepeatedWarning& operator=(RepeatedWarning&&) = delete;

  void Tell(const std::string& text);

 private:
  std::string what_;
  int count_ = 0;
};

}  // namespace surfit
