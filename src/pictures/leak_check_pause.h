#pragma once

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace surfit {

// While it lives, what this thread allocates is not reported as leaked by AddressSanitizer: Cairo's
// fontconfig and libltdl under PLplot keep a fixed 16 kB to the end of the process, reachable only
// from modules that are unloaded by then. In other builds it is nothing.
class LeakCheckPause {
 public:
#if defined(__SANITIZE_ADDRESS__)
  LeakCheckPause() { __lsan_disable(); }
  ~LeakCheckPause() { __lsan_enable(); }
#else
  LeakCheckPause() {}
  ~LeakCheckPause() {}
#endif
  LeakCheckPause(const LeakCheckPause&) = delete;
  LeakCheckPause& operator=(const LeakCheckPause&) = delete;
};

}  // namespace surfit
