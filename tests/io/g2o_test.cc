#include "surfit/io/g2o.h"

#include <gmock/gmock.h>

#include "testing/matchers.h"
#include "testing/pose_graphs.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Upper triangle of the identity, row-major.
const std::string kIdentity = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
const std::string kVertices =
    "VERTEX_SE3:QUAT 7 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 8 1 2 3 0 0 0.6 0.8\n";

TEST(G2o, ReadsPosesEdgesAndFixedVertices) {
  const TempFolder folder;
  // Information: diagonal 1 to 3 for translation, 4 to 6 for rotation, and one off-diagonal entry.
  const std::string edge =
      "EDGE_SE3:QUAT 7 8 1 2 3 0 0 0.6 0.8 1 0 0 0 0 0.5 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6\n";
  const G2oFile file = ReadG2o(
      folder.Write("a.g2o", "# comment\n\n" + edge + kVertices + "FIX 8\nPARAMS 0\nPARAMS 1\r\n"));
  ASSERT_EQ(file.graph.poses.size(), 2u);
  EXPECT_EQ(file.graph.poses[1].id, 8);
  EXPECT_FALSE(file.graph.poses[0].fixed);
  EXPECT_TRUE(file.graph.poses[1].fixed);
  const Rigid3d pose(Eigen::Quaterniond(0.8, 0, 0, 0.6), {1, 2, 3});
  EXPECT_THAT(file.graph.poses[1].world_from_pose, RigidNear(pose, 1e-15, 1e-15));
  ASSERT_EQ(file.graph.edges.size(), 1u);
  const PoseGraphEdge& e = file.graph.edges[0];
  EXPECT_EQ(e.a, 1u);
  EXPECT_EQ(e.b, 0u);
  EXPECT_FALSE(e.loop);
  EXPECT_THAT(e.a_from_b, RigidNear(pose.Inverse(), 1e-15, 1e-15));
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  information.diagonal() << 4, 5, 6, 1, 2, 3;
  information(2, 3) = information(3, 2) = 0.5;
  EXPECT_EQ(e.information, information);
  EXPECT_EQ(file.ignored_lines, (std::map<std::string, std::size_t>{{"PARAMS", 2}}));
  file.graph.Validate();
}

// The residual is that of g2o: i_from_j^-1 * estimate, rotation in rad.
TEST(G2o, CostUsesTheErrorInTheFrameOfTheSecondPose) {
  const TempFolder folder;
  const std::string edge =
      "EDGE_SE3:QUAT 7 8 1.5 2 3 0 0 0.6 0.8 2 0 0 0 0 0 2 0 0 0 0 2 0 0 0 1 0 0 1 0 1\n";
  EXPECT_NEAR(Cost(ReadG2o(folder.Write("a.g2o", kVertices + edge)).graph), 0.5 * 2 * 0.25, 1e-14);
  const std::string turned = "EDGE_SE3:QUAT 7 8 1 2 3 0 0 0 1" + kIdentity + "\n";
  const double angle = 2 * std::asin(0.6);
  EXPECT_NEAR(Cost(ReadG2o(folder.Write("b.g2o", kVertices + turned)).graph), 0.5 * angle * angle,
              1e-14);
}

TEST(G2o, RoundTripsGraphs) {
  const TempFolder folder;
  PoseGraph graph = MakeTorus(5, 6).graph;
  graph.poses[3].fixed = true;
  graph.edges[0].information(1, 4) = graph.edges[0].information(4, 1) = 3;
  WriteG2o(graph, folder / "a.g2o");
  const PoseGraph read = ReadG2o(folder / "a.g2o").graph;
  ASSERT_EQ(read.poses.size(), graph.poses.size());
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    EXPECT_EQ(read.poses[i].id, graph.poses[i].id);
    EXPECT_EQ(read.poses[i].fixed, graph.poses[i].fixed);
    EXPECT_THAT(read.poses[i].world_from_pose,
                RigidNear(graph.poses[i].world_from_pose, 1e-14, 1e-14));
  }
  ASSERT_EQ(read.edges.size(), graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    EXPECT_EQ(read.edges[i].a, graph.edges[i].a);
    EXPECT_EQ(read.edges[i].b, graph.edges[i].b);
    EXPECT_EQ(read.edges[i].loop, graph.edges[i].loop);
    EXPECT_EQ(read.edges[i].information, graph.edges[i].information);
    EXPECT_THAT(read.edges[i].a_from_b, RigidNear(graph.edges[i].a_from_b, 1e-13, 1e-13));
  }
}

TEST(G2o, ReadsSingularInformationMatrices) {
  const TempFolder folder;
  const G2oFile file = ReadG2o(folder.Write(
      "a.g2o", kVertices + "EDGE_SE3:QUAT 7 8 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0" +
                   " 0 0 0 0 0 0\n"));
  Eigen::Matrix<double, 6, 1> translations;
  translations << 0, 0, 0, 1, 1, 1;
  EXPECT_EQ(file.graph.edges[0].information.diagonal(), translations);
}

TEST(G2o, RejectsBadFilesByLineAndValue) {
  const TempFolder folder;
  const auto refuse = [&](const std::string& line, const auto&... names) {
    const std::string path = folder.Write("bad.g2o", kVertices + line + "\n");
    ExpectInputError([&] { ReadG2o(path); }, Names(path + ":3", names...));
  };
  refuse("VERTEX_SE3:QUAT 7 0 0 0 0 0 0 1", 7);
  refuse("VERTEX_SE3:QUAT 9 0 0 0 0 0 1", "VERTEX_SE3:QUAT", 8, 9);
  refuse("VERTEX_SE3:QUAT 9 0 0 nan 0 0 0 1", "nan");
  refuse("VERTEX_SE3:QUAT -9 0 0 0 0 0 0 1", -9);
  refuse("VERTEX_SE3:QUAT 9 0 0 0 0 0 0 2", 2, 1);
  refuse("EDGE_SE3:QUAT 7 9 0 0 0 0 0 0 1" + kIdentity, 9);
  refuse("EDGE_SE3:QUAT 7 7 0 0 0 0 0 0 1" + kIdentity);
  refuse("EDGE_SE3:QUAT 7 8 0 0 0 0 0 0 1 1", "EDGE_SE3:QUAT", 11, 31);
  refuse("EDGE_SE3:QUAT 7 8 0 0 0 0 0 0 1 -1" + kIdentity.substr(2));
  refuse("EDGE_SE3:QUAT 7 8 1e160 0 0 0 0 0 1" + kIdentity, "1e+160");
  refuse("EDGE_SE3:QUAT 7 8 0 0 0 0 0 0 1 1e160" + kIdentity.substr(2), "1e160");
  refuse("FIX 9", 9);
  refuse("VERTEX_SE2 9 0 0 0", "VERTEX_SE2", "SE(2)", "SE(3)");
  refuse("EDGE_SE3_PRIOR 7 5 0 0 0 0 0 0 1" + kIdentity, "PARAMS_SE3OFFSET", 5);
  refuse("EDGE_POINTXYZ_PRIOR 9 0 0 0 1 0 0 1 0 1", 9);
  refuse("EDGE_POINTXYZ_PRIOR 7 0 0 0 1 0 0 -1 0 1", -1, "--indefinite_information");
  const std::string empty = folder.Write("empty.g2o", "SOMETHING 0 0 0 0\n");
  ExpectInputError([&] { ReadG2o(empty); }, Names("empty.g2o", "VERTEX_SE3:QUAT"));
  ExpectInputError([&] { ReadG2o(folder / "none.g2o"); }, Names("none.g2o"));
}

TEST(G2o, ReadsAndWritesPlanarGraphs) {
  const TempFolder folder;
  const std::string text =
      "VERTEX_SE2 3 1 2 0.5\nVERTEX_SE2 9 2 3 1\nFIX 3\n"
      "EDGE_SE2 3 9 1.5 0.25 0.5 1 0.5 0.25 2 0.125 3\n"
      "EDGE_PRIOR_SE2 9 2 3 0.75 1 0 0 2 0 3\nEDGE_PRIOR_SE2_XY 9 2.5 3 4 1 5\n";
  const PoseGraph graph = ReadG2o(folder.Write("a.g2o", text)).graph;
  EXPECT_TRUE(graph.planar);
  graph.Validate();
  ASSERT_EQ(graph.edges.size(), 1u);
  EXPECT_FALSE(graph.edges[0].loop);
  Eigen::Matrix3d information;
  information << 3, 0.25, 0.125, 0.25, 1, 0.5, 0.125, 0.5, 2;  // (angle, x, y)
  EXPECT_EQ((graph.edges[0].information.block<3, 3>(2, 2)), information);
  ASSERT_EQ(graph.priors.size(), 1u);
  ASSERT_EQ(graph.positions.size(), 1u);
  EXPECT_NEAR(SquaredError(graph, graph.priors[0]), 3 * 0.25 * 0.25, 1e-12);
  EXPECT_NEAR(SquaredError(graph, graph.positions[0]), 4 * 0.25, 1e-12);
  WriteG2o(graph, folder / "b.g2o");
  const PoseGraph read = ReadG2o(folder / "b.g2o").graph;
  EXPECT_TRUE(read.planar);
  EXPECT_TRUE(read.poses[0].fixed);
  EXPECT_NEAR(Cost(read), Cost(graph), 1e-12 * Cost(graph));
}

TEST(G2o, ReadsPriorsWithTheirOffset) {
  const TempFolder folder;
  const std::string text = kVertices +
                           "PARAMS_SE3OFFSET 4 0 0 1 0 0 0 1\n"
                           "EDGE_SE3_PRIOR 7 4 0 0 3 0 0 0 1" +
                           kIdentity +
                           "\nEDGE_POINTXYZ_PRIOR 8 1 2 4 1 0 0 1 0 9\n"
                           "EDGE_SE3_XYZPRIOR 8 4 1 2 6 1 0 0 1 0 1\n";
  const PoseGraph graph = ReadG2o(folder.Write("a.g2o", text)).graph;
  ASSERT_EQ(graph.priors.size(), 1u);
  ASSERT_EQ(graph.positions.size(), 2u);
  EXPECT_NEAR(SquaredError(graph, graph.priors[0]), 4, 1e-12);     // 3 m - 1 m
  EXPECT_NEAR(SquaredError(graph, graph.positions[0]), 9, 1e-12);  // 4 m - 3 m
  EXPECT_NEAR(SquaredError(graph, graph.positions[1]), 4, 1e-12);  // 6 m - 4 m
  WriteG2o(graph, folder / "b.g2o");
  EXPECT_NEAR(Cost(ReadG2o(folder / "b.g2o").graph), Cost(graph), 1e-12);
}

TEST(G2o, ChainsPosesOfAFileWithoutVertices) {
  const TempFolder folder;
  const std::string tail = " 0 0 0 0 0 1" + kIdentity + "\n";
  const G2oFile file =
      ReadG2o(folder.Write("a.g2o", "EDGE_SE3:QUAT 5 2 2" + tail + "EDGE_SE3:QUAT 9 5 3" + tail));
  EXPECT_EQ(file.chained_count, 3u);
  ASSERT_EQ(file.graph.poses.size(), 3u);
  EXPECT_EQ(file.graph.poses[0].id, 2);
  EXPECT_NEAR(file.graph.poses[1].world_from_pose.translation.x(), -2, 1e-12);
  EXPECT_NEAR(file.graph.poses[2].world_from_pose.translation.x(), -5, 1e-12);
}

TEST(G2o, ChangesIndefiniteInformationOnRequestOnly) {
  const TempFolder folder;
  // (x, qx) has the block [1 2; 2 1] with the eigenvalues 3 and -1.
  const std::string path = folder.Write(
      "a.g2o",
      kVertices + "EDGE_SE3:QUAT 7 8 0 0 0 0 0 0 1 1 0 0 2 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n");
  ExpectInputError([&] { ReadG2o(path); }, Names(path + ":3", -1, "--indefinite_information"));
  G2oOptions options;
  options.indefinite_information = "project";
  G2oFile file = ReadG2o(path, options);
  EXPECT_EQ(file.indefinite_count, 1u);
  EXPECT_NEAR(file.graph.edges[0].information(0, 3), 1.5, 1e-12);
  EXPECT_NEAR(file.graph.edges[0].information(0, 0), 1.5, 1e-12);
  options.indefinite_information = "blocks";
  file = ReadG2o(path, options);
  EXPECT_EQ(file.indefinite_count, 1u);
  EXPECT_EQ(file.graph.edges[0].information, (Eigen::Matrix<double, 6, 6>::Identity()));
  options.indefinite_information = "some";
  ExpectInputError([&] { ReadG2o(path, options); }, Names("indefinite_information", "some"));
}

}  // namespace
}  // namespace surfit::testing
