#include <gtest/gtest.h>

#include <type_traits>

#include "cost_functions/batch_sums.h"
#include "cost_functions/point_to_plane.h"
#include "cost_functions/symmetric_point_to_plane.h"

namespace surfit {
namespace {

// That a branch does not compile, and with which words, is tested by building
// branching_functor.cc (see CMakeLists.txt).
TEST(BatchFunctors, ThreeDerivativesServeWhereTheMovedPointIsAll) {
  EXPECT_TRUE((UsesMovedPointOnly<PointToPlane, Lanes<float>>::value));
  EXPECT_FALSE((UsesMovedPointOnly<SymmetricPointToPlane, Lanes<float>>::value));
}

}  // namespace
}  // namespace surfit
