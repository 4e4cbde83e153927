#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "surfit/io/point_cloud.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

class EvaluateMapTest : public ::testing::Test {
 protected:
  EvaluateMapTest() {
    // A row of reference points 0.25 m apart with normals along z; surfels over the first three of
    // them, 1/128 m, 1/128 m and 0.5 m above.
    PointCloud reference;
    for (int i = 0; i < 4; ++i) {
      reference.points.push_back({0.25f * i, 0, 0});
      reference.normals.push_back({0, 0, 1});
    }
    WritePly(reference, folder_ / "reference.ply");
    SurfelMap map;
    for (int i = 0; i < 3; ++i) {
      Surfel surfel;
      surfel.position_in_world = {0.25f * i, 0, i == 2 ? 0.5f : 0.0078125f};
      map.Append(surfel);
    }
    WriteSurfelPly(map, folder_ / "map.ply");
  }
  ProgramResult Evaluate(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "--reference=" + (folder_ / "reference.ply"));
    flags.insert(flags.begin(), "--map=" + (folder_ / "map.ply"));
    return RunProgram("surfit_evaluate_map", flags);
  }
  TempFolder folder_;
};

TEST_F(EvaluateMapTest, PrintsAccuracyAndCompletenessAsJson) {
  const ProgramResult result = Evaluate({});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("accuracy_mean_m"), (2 * 0.0078125 + 0.5) / 3);
  EXPECT_EQ(json.at("accuracy_median_m"), 0.0078125);
  EXPECT_NEAR(json.at("accuracy_p90_m"), 0.0078125 + 0.8 * (0.5 - 0.0078125), 1e-12);
  EXPECT_EQ(json.at("plane_accuracy_max_m"), 0.5);
  EXPECT_EQ(json.at("completeness"), 0.5);  // two of four within the default of 1 cm
  EXPECT_EQ(json.at("map_points"), 3);
  EXPECT_EQ(json.at("reference_points"), 4);
}

// At 0.5 m, inclusive, the third point counts too; the fourth is sqrt(0.25^2 + 0.5^2) m away.
TEST_F(EvaluateMapTest, TakesTheDistanceOfCompletenessFromTheFlag) {
  const ProgramResult result = Evaluate({"--completeness_distance_m=0.5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("completeness"), 0.75);
}

// A map whose run began a quarter of a turn and a metre away from the reference's frame. A map that
// is compared as it lies is 1 m and more off.
TEST_F(EvaluateMapTest, TakesTheMapToTheReferenceAsTheTrajectoryIs) {
  const std::string truth =
      folder_.Write("truth.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n");
  const std::string estimate =
      folder_.Write("estimate.txt", "0 0 0 1 0 0 0 1\n1 0 1 1 0 0 0 1\n2 -1 1 1 0 0 0 1\n");
  SurfelMap map;
  for (int i = 0; i < 3; ++i) {
    Surfel surfel;
    surfel.position_in_world = {0, 0.25f * i, 1.0078125f};
    map.Append(surfel);
  }
  WriteSurfelPly(map, folder_ / "map.ply");
  EXPECT_GT(nlohmann::json::parse(Evaluate({}).out).at("accuracy_median_m"), 1);
  const ProgramResult result = Evaluate({"--estimate=" + estimate, "--groundtruth=" + truth});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_NEAR(json.at("accuracy_max_m"), 0.0078125, 1e-6);  // single precision at 1 m
  EXPECT_EQ(json.at("completeness"), 0.75);
  EXPECT_NEAR(json.at("reference_from_map").at("translation_m").at(2), -1, 1e-12);
}

TEST_F(EvaluateMapTest, RefusesTrajectoriesThatPlaceNoMap) {
  const std::string straight =
      folder_.Write("straight.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
  ExpectRefused(Evaluate({"--estimate=" + straight, "--groundtruth=" + straight}),
                "straight.txt place no map, must be at least 3 that are not in a line");
  ExpectRefused(Evaluate({"--estimate=" + straight}), "--groundtruth is missing, must be set");
}

TEST_F(EvaluateMapTest, RefusesBadInput) {
  ExpectRefused(Evaluate({"--completeness_distance_m=0"}), "completeness_distance_m is 0, must be");
  ExpectRefused(Evaluate({"--map=" + folder_.Write("bad.ply", "solid cube")}),
                "bad.ply: neither PLY nor PCD");
  ExpectRefused(Evaluate({"--map=" + (folder_ / "none.ply")}), "none.ply': No such file");
  ExpectRefused(RunProgram("surfit_evaluate_map", {}), "--map is missing, must be set");
  WriteSurfelPly(SurfelMap(), folder_ / "empty.ply");
  ExpectRefused(Evaluate({"--map=" + (folder_ / "empty.ply")}), "the map has no finite point");
}

}  // namespace
}  // namespace surfit::testing
