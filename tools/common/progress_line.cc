#include "common/progress_line.h"

#include <unistd.h>

#include <cstdio>

namespace surfit::tools {

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressLine::Show(const std::string& text, double elapsed_s, bool last) {
  if (!last && elapsed_s - shown_s_ < (terminal_ ? 0.2 : 10)) return;
  shown_s_ = elapsed_s;
  std::fprintf(stderr, "%s%s%s", terminal_ ? "\r" : "", text.c_str(),
               terminal_ && !last ? "   " : "\n");
}

}  // namespace surfit::tools
