#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace surfit {

// oneTBB's prebuilt library is not instrumented, so ThreadSanitizer cannot see that its fork and
// join order memory. This states that order; in other builds it is nothing. Make it static: a
// worker that reads its address from what the caller wrote would do so before it has acquired
// anything.
class SanitizerFence {
 public:
#if defined(__SANITIZE_THREAD__)
  void Release() { __tsan_release(this); }
  void Acquire() { __tsan_acquire(this); }
#else
  void Release() {}
  void Acquire() {}
#endif

 private:
  char address_ = 0;
};

}  // namespace surfit
