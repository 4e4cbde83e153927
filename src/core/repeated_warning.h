#pragma once

#include <string>

namespace surfit {

// A warning that may come for thousands of frames: the first few are logged, the others counted,
// and their number is told in the end.
class RepeatedWarning {
 public:
  // Of what there may be many, for the count: "frames skipped".
  explicit RepeatedWarning(std::string what);
  ~RepeatedWarning();
  RepeatedWarning& operator=(RepeatedWarning&&) = delete;

  void Tell(const std::string& text);

 private:
  std::string what_;
  int count_ = 0;
};

}  // namespace surfit
