#pragma once

#include <string>
#include <vector>

namespace surfit {

// Errors of a run. Each step is tried even if earlier steps have failed, so that results are not
// lost.
class Failures {
 public:
  Failures();

  // Runs the step. Returns false after an exception, whose message is stored once.
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
  // All messages, joined by "; ". Empty without errors.
  std::string text() const;

 private:
  void AddCurrent();

  std::vector<std::string> all_;
  std::vector<char> reserve_;  // freed when memory runs out, so that results can be written
};

}  // namespace surfit
