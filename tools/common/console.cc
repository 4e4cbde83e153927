#include "common/console.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iomanip>

#include "surfit/core/error.h"

namespace surfit::tools {

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

double ProgressLine::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void ProgressLine::Show(const std::string& text, bool last) {
  const double now_s = elapsed_s();
  if (!last && now_s - shown_s_ < (terminal_ ? 0.2 : 10)) return;
  shown_s_ = now_s;
  std::fprintf(stderr, "%s%s%s", terminal_ ? "\r" : "", text.c_str(),
               terminal_ && !last ? "   " : "\n");
}

std::string TextTable(const std::vector<std::vector<std::string>>& rows, std::size_t left_columns) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - row[i].size(), ' ');
      text += (i > 0 ? "  " : "") + (i < left_columns ? row[i] + padding : padding + row[i]);
    }
    text += '\n';
  }
  return text;
}

std::string Number(double value, int digits) { return Concat(std::setprecision(digits), value); }

namespace {

std::atomic<bool> interrupted{false};

}  // namespace

void PrepareStreams() {
  constexpr int kStreams[] = {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO};
  for (const int stream : kStreams) {
    // Gets the smallest free number: `stream`.
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", O_RDWR);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

const std::atomic<bool>& CatchInterruptions() {
  const auto note = [](int) { interrupted = true; };
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, note) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  return interrupted;
}

void Interrupt() { interrupted = true; }

}  // namespace surfit::tools
