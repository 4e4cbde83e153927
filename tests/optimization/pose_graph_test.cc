#include "surfit/optimization/pose_graph.h"

#include <gmock/gmock.h>

#include <limits>

#include "testing/expect_input_error.h"
#include "testing/pose_graphs.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;

PoseGraph Small() { return testing::MakeSphere(3, 5).graph; }

TEST(PoseGraph, CostOfOdometryAloneIsThatOfItsLoops) {
  const PoseGraph graph = Small();
  double loops = 0;
  for (const PoseGraphEdge& edge : graph.edges) {
    const double error = SquaredError(graph, edge);
    if (edge.loop) {
      loops += error / 2;
    } else {
      EXPECT_LT(error, 1e-15);
    }
  }
  EXPECT_GT(loops, 1);
  EXPECT_NEAR(Cost(graph), loops, 1e-12 * loops);
}

TEST(PoseGraph, RefusesImpossibleGraphs) {
  Small().Validate();
  PoseGraph graph = Small();
  graph.poses[3].id = 2;
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("the id 2 of a pose must be unique"));
  graph = Small();
  graph.poses[3].world_from_pose.translation.x() = std::numeric_limits<double>::quiet_NaN();
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("pose 3 must be finite"));
  graph = Small();
  graph.edges[1].b = 15;
  ExpectInputError([&] { graph.Validate(); },
                   HasSubstr("edge 1 joins poses 1 and 15, must be two of 15"));
  graph = Small();
  graph.edges[1].information(0, 0) *= -1;
  ExpectInputError([&] { graph.Validate(); },
                   HasSubstr("information of the edge between poses 1 and 2 must be"));
  graph = Small();
  graph.edges[1].information(0, 1) += 1;
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("symmetric"));
  graph = Small();
  graph.edges[1].a_from_b.rotation.coeffs() *= 2;
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("unit quaternion"));
}

}  // namespace
}  // namespace surfit
