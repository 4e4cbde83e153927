#include "common/interruption.h"

#include <csignal>

namespace surfit::tools {
namespace {

std::atomic<bool> interrupted{false};

}  // namespace

const std::atomic<bool>& CatchInterruptions() {
  const auto note = [](int) { interrupted = true; };
  std::signal(SIGINT, note);
  std::signal(SIGTERM, note);
  return interrupted;
}

}  // namespace surfit::tools
