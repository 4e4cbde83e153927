#pragma once

#include <string>
#include <vector>

namespace surfit {

// What has gone wrong in a run that goes on, so that what it has done is not lost: each step is
// tried, whatever has become of those before it.
class Failures {
 public:
  Failures();

  // Whether the step has done what it should: any exception is kept as its message.
  template <typename Step>
  bool Try(const Step& step) {
    try {
      step();
      return true;
    } catch (...) {
      AddCurrent();
      return false;
    }
  }

  bool any() const { return !all_.empty(); }
  // One sentence of all of them; empty without any.
  std::string text() const;

 private:
  void AddCurrent();

  std::vector<std::string> all_;
  std::vector<char> reserve_;  // memory for saving a run that has no more
};

}  // namespace surfit
