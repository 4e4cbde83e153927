#pragma once

#include <string>
#include <vector>

namespace surfit {

// Errors of a run. Later steps run in spite of errors, so that results are not lost. Keeps 32 MiB
// free to report a lack of memory. Not thread-safe.
class Failures {
 public:
  Failures();

  // Runs the step. Returns false and stores the message after an exception. Equal messages are
  // stored once.
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
  std::vector<char> reserve_;  // freed when memory runs out
};

}  // namespace surfit
