#include "optimization/single_threaded_blas.h"

#include <dlfcn.h>

namespace surfit {
namespace {

// Sets a library's number of threads, and gives the one before; 0 where it is not loaded.
int SetThreads(const char* getter, const char* setter, int count) {
  const auto get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, getter));
  const auto set = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, setter));
  if (get == nullptr || set == nullptr) return 0;
  const int former = get();
  set(count);
  return former;
}

int SetOpenMpThreads(int count) {
  return SetThreads("omp_get_max_threads", "omp_set_num_threads", count);
}

int SetOpenBlasThreads(int count) {
  return SetThreads("openblas_get_num_threads", "openblas_set_num_threads", count);
}

}  // namespace

SingleThreadedBlas::SingleThreadedBlas()
    : openmp_threads_(SetOpenMpThreads(1)), openblas_threads_(SetOpenBlasThreads(1)) {}

SingleThreadedBlas::~SingleThreadedBlas() {
  if (openblas_threads_ > 0) SetOpenBlasThreads(openblas_threads_);
  if (openmp_threads_ > 0) SetOpenMpThreads(openmp_threads_);
}

}  // namespace surfit
