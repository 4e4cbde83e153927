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

  // Counts an occurrence, and logs its text if it is one of the first three.
  void Tell(const std::string& text);

 private:
  std::string what_;
  int count_ = 0;
};

}  // namespace surfit
