#pragma once

namespace surfit {

// While it lives, OpenMP's loops that begin on this thread (CHOLMOD's) and OpenBLAS, where they are
// loaded, use one thread, so that sums are in the same order whatever the machine. Debian's own
// BLAS has one anyway.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;

 private:
  int openmp_threads_, openblas_threads_;
};

}  // namespace surfit
