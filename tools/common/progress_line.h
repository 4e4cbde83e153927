#pragma once

#include <string>

namespace surfit::tools {

// How far a program is, on stderr: one line that is written over on a terminal, and now and then a
// new one elsewhere.
class ProgressLine {
 public:
  ProgressLine();
  void Show(const std::string& text, double elapsed_s, bool last);

 private:
  bool terminal_;
  double shown_s_ = 0;
};

}  // namespace surfit::tools
