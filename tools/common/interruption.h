#pragma once

#include <atomic>

namespace surfit::tools {

// From now on SIGINT (Ctrl-C) and SIGTERM set the flag that is returned instead of ending the
// program, so that it can finish what it writes.
const std::atomic<bool>& CatchInterruptions();

}  // namespace surfit::tools
