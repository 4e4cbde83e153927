// Functor with a branch on a residual value. A batch of it must not compile.
#include "cost_functions/point_functor.h"
#include "cost_functions/reduced_batch.h"

namespace surfit::testing {

struct Branching : PointFunctor<Branching, 4, 1> {
  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* d, T* residuals) const {
    residuals[0] = y[0] - d[3];
    if (y[0] < y[1]) residuals[0] = y[1] - d[3];
  }
};

ceres::CostFunction* MakeCost(const BatchData<Branching, float>& data) {
  return new ReducedBatch<Branching>(Branching(), data, RobustKernel());
}

}  // namespace surfit::testing
