#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

namespace surfit::tools {

// How far a program is, on stderr: one line that is written over on a terminal, and now and then a
// new one elsewhere.
class ProgressLine {
 public:
  ProgressLine();
  void Show(const std::string& text, bool last);
  double elapsed_s() const;  // since the line was made

 private:
  bool terminal_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double shown_s_ = 0;
};

// Lines of columns that are as wide as their widest cell: the first `left_columns` of them begin
// together, the others end together. All rows have the same number of cells.
std::string TextTable(const std::vector<std::vector<std::string>>& rows, std::size_t left_columns);

// A number with this many significant digits.
std::string Number(double value, int digits = 6);

// Opens stdin, stdout and stderr that the program was started without on /dev/null: else the next
// files that it opens would be taken for them. And what is written to a closed pipe, or beyond the
// largest size that files may have, fails where it is written instead of ending the program.
void PrepareStreams();

// From now on SIGINT (Ctrl-C), SIGTERM and SIGHUP (the terminal is gone) set the flag that is
// returned instead of ending the program, so that it can finish what it writes. Those that whoever
// started the program wants to be ignored, as nohup does, stay so.
const std::atomic<bool>& CatchInterruptions();

// Sets that flag, also where signals are ignored. Any thread may call it.
void Interrupt();

}  // namespace surfit::tools
