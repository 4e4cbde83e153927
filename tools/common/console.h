#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

namespace surfit::tools {

// Progress on stderr: one line that is overwritten on a terminal; otherwise a new line at most
// every 10 s.
class ProgressLine {
 public:
  ProgressLine();
  // Shows the text, at most every 0.2 s on a terminal and every 10 s elsewhere, not at the start.
  // `last`: always shows the text and ends the line.
  void Show(const std::string& text, bool last);
  double elapsed_s() const;  // since construction

 private:
  bool terminal_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double shown_s_ = 0;
};

// Text table. Columns are as wide as their widest cell. The first `left_columns` columns are
// aligned to the left, the others to the right. All rows have the same number of cells.
std::string TextTable(const std::vector<std::vector<std::string>>& rows, std::size_t left_columns);

// Text of a number with `digits` significant digits.
std::string Number(double value, int digits = 6);

// Opens closed standard streams (stdin, stdout, stderr) on /dev/null, so that other files do not
// get their numbers. Ignores SIGPIPE and SIGXFSZ: writing to a closed pipe, or beyond the limit of
// the file size, fails instead of ending the program.
void PrepareStreams();

// SIGINT (Ctrl-C), SIGTERM and SIGHUP (closed terminal) set the returned flag instead of ending the
// program, so that it can complete its files. Signals that are ignored at the start, as under
// nohup, stay ignored.
const std::atomic<bool>& CatchInterruptions();

// Sets this flag without a signal. Thread-safe.
void Interrupt();

}  // namespace surfit::tools
