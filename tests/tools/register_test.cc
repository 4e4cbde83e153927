#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "surfit/geometry/rigid3.h"
#include "surfit/io/point_cloud.h"
#include "testing/matchers.h"
#include "testing/run_program.h"
#include "testing/shared_data.h"

namespace surfit::testing {
namespace {

constexpr double kSigma_m = 0.001;

// Three walls of 1 m in front of the origin, with 4000 noisy points each.
PointCloud Corner(int seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, kSigma_m);
  PointCloud cloud;
  for (int wall = 0; wall < 3; ++wall) {
    for (int i = 0; i < 4000; ++i) {
      Eigen::Vector3d point(uniform(rng), uniform(rng), uniform(rng));
      point[wall] = noise(rng);
      const Eigen::Vector3d in_camera(point.x() - 0.5, point.y() - 0.5, 2.5 - point.z());
      cloud.points.push_back(in_camera.cast<float>());
    }
  }
  return cloud;
}

const Rigid3d& Truth() {
  static const Rigid3d truth(QuaternionExp<double>({0.02, -0.03, 0.01}), {0.03, -0.02, 0.04});
  return truth;
}

// The corner in the frame of the source.
PointCloud MovedCorner(int seed) {
  PointCloud cloud = Corner(seed);
  const Rigid3d source_from_target = Truth().Inverse();
  for (auto& point : cloud.points) {
    point = (source_from_target * point.cast<double>()).cast<float>();
  }
  return cloud;
}

Rigid3d ParseTransform(const std::string& text) {
  std::istringstream stream(text);
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) stream >> matrix(i / 4, i % 4);
  EXPECT_EQ(matrix.row(3), Eigen::RowVector4d(0, 0, 0, 1));
  return {Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>()};
}

class RegisterTool : public ::testing::Test {
 protected:
  RegisterTool() {
    WritePly(MovedCorner(1), Source());
    WritePly(Corner(2), Target());
  }
  std::string Source() const { return folder_ / "source.ply"; }
  std::string Target() const { return folder_ / "target.ply"; }
  std::string Output(const std::string& name) const { return folder_ / "out" + "/" + name; }
  using RunFlags = std::vector<std::string>;
  ProgramResult Register(const std::string& source, const std::string& target,
                         RunFlags flags = {}) const {
    flags.insert(flags.begin(),
                 {"--source=" + source, "--target=" + target, "--output=" + (folder_ / "out")});
    return RunProgram("surfit_register", flags);
  }

  TempFolder folder_;
};

// N = 4000 points with an RMS distance of 0.41 m to the centre of a wall determine the rotation to
// sqrt(2) sigma / (0.41 sqrt(N)) = 5.5e-5 rad. 4 sigma of three walls are 4e-4 rad, or 1 mm at the
// origin, 2.5 m away.
constexpr double kTolerance_rad = 4e-4, kTolerance_m = 1e-3;

TEST_F(RegisterTool, FindsThePoseAndWritesIt) {
  const ProgramResult result = Succeeded(Register(Source(), Target()));
  EXPECT_THAT(result.out,
              AllOf(Names("source", 12000),
                    ContainsRegex("iter 0: avg loss = [0-9.]+e[-+][0-9]+, inlier count = [0-9]+\n"),
                    Names("converged", "rmse", "target_from_source")));
  const Rigid3d pose = ParseTransform(ReadBytes(Output("transform.txt")));
  EXPECT_THAT(pose, RigidNear(Truth(), kTolerance_m, kTolerance_rad));

  const auto json = nlohmann::json::parse(ReadBytes(Output("registration.json")));
  const Eigen::Matrix4d matrix = pose.Matrix();
  for (int i = 0; i < 16; ++i) {
    EXPECT_NEAR(json["target_from_source"][i / 4][i % 4], matrix(i / 4, i % 4), 1e-12);
  }
  EXPECT_EQ(json["termination"], "converged");
  EXPECT_EQ(json["covariance"].size(), 6u);
  EXPECT_EQ(json["source"]["points"], 12000);
  EXPECT_EQ(json["options"]["association"], "kd_tree");

  const PointCloud source = ReadPly(Source()), aligned = ReadPly(Output("aligned.ply"));
  ASSERT_EQ(aligned.points.size(), source.points.size());
  EXPECT_EQ(aligned.normals.size(), source.points.size());
  for (std::size_t i = 0; i < source.points.size(); i += 1000) {
    const Eigen::Vector3d expected = pose * source.points[i].cast<double>();
    EXPECT_THAT(aligned.points[i].cast<double>(), VectorNear(expected, 1e-6));
  }
  for (const char* name : {"before.png", "after.png"}) {
    EXPECT_THAT(ReadBytes(Output(name)), StartsWith("\x89PNG"));
  }
}

TEST_F(RegisterTool, UsesNormalsOfTheFilesAndSkipsNonFinitePoints) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  PointCloud target = Corner(2);
  for (int i = 0; i < 12000; ++i) {
    const Eigen::Vector3f inwards[] = {{2, 0, 0}, {0, 2, 0}, {0, 0, -2}};  // not normalised
    target.normals.push_back(inwards[i / 4000]);
  }
  target.normals[7].setZero();
  target.points.push_back({kNan, 0, 0});
  target.normals.push_back({0, 0, 1});
  WritePly(target, Target());
  const ProgramResult result =
      Succeeded(Register(Source(), Target(), {"--max_normal_angle_deg=0"}));
  EXPECT_THAT(result.out, Names("target", 12000, 1));
  EXPECT_THAT(ParseTransform(ReadBytes(Output("transform.txt"))),
              RigidNear(Truth(), kTolerance_m, kTolerance_rad));
}

TEST_F(RegisterTool, RegistersByEachResidualAndSolver) {
  for (const char* flag : {"--residual=symmetric_point_to_plane", "--residual=plane_to_plane",
                           "--solver=ceres", "--solver=tiny", "--solver=closed_form_qr"}) {
    SCOPED_TRACE(flag);
    Succeeded(Register(Source(), Target(), {flag}));
    EXPECT_THAT(ParseTransform(ReadBytes(Output("transform.txt"))),
                RigidNear(Truth(), kTolerance_m, kTolerance_rad));
  }
}

TEST_F(RegisterTool, FailsWithoutOverlap) {
  PointCloud far = Corner(1);
  for (auto& point : far.points) point.x() += 100;
  WritePly(far, Source());
  const ProgramResult result = Register(Source(), Target(), {"--start=identity"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, StartsWith("failed: too_few_inliers: "));
}

TEST_F(RegisterTool, StartsFromGivenPose) {
  PointCloud far = MovedCorner(1);
  for (auto& point : far.points) point.x() += 3;
  WritePly(far, Source());
  const std::string file = folder_ / "pose.txt";
  std::ofstream(file) << "1 0 0 -3\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  for (const std::string& pose : {std::string("-3,0,0,0,0,0,1"), file}) {
    Succeeded(Register(Source(), Target(), {"--start=" + pose}));
    const Rigid3d expected =
        Truth() * Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-3, 0, 0));
    EXPECT_THAT(ParseTransform(ReadBytes(Output("transform.txt"))),
                RigidNear(expected, 3 * kTolerance_m, kTolerance_rad));
  }
}

// Coordinates of a survey: single precision has steps of 0.5 m there.
TEST_F(RegisterTool, KeepsPrecisionFarFromTheOrigin) {
  const Eigen::Vector3d origin(500000, 5400000, 300);
  PointCloud source = MovedCorner(1), target = Corner(2);
  source.origin = target.origin = origin;
  WritePly(source, Source());
  WritePly(target, Target());
  Succeeded(Register(Source(), Target()));
  const Rigid3d found = ParseTransform(ReadBytes(Output("transform.txt")));
  const Eigen::Vector3d point(0.1, 0.2, 2);
  EXPECT_THAT(Eigen::Vector3d(found * (origin + point) - origin),
              VectorNear(Eigen::Vector3d(Truth() * point), kTolerance_m));
}

TEST_F(RegisterTool, EstimatesNormalsIfAllAreZeroAndCountsEqualPoints) {
  PointCloud source = MovedCorner(1);
  source.points.resize(20000, Eigen::Vector3f::Zero());
  source.normals.assign(source.points.size(), Eigen::Vector3f::Zero());
  WritePly(source, Source());
  const ProgramResult result = Succeeded(Register(Source(), Target()));
  EXPECT_THAT(result.out, Names("source", 20000, 7999, "equal"));
  EXPECT_THAT(ParseTransform(ReadBytes(Output("transform.txt"))),
              RigidNear(Truth(), kTolerance_m, kTolerance_rad));
}

TEST_F(RegisterTool, EstimatesNormalsIfAllAreEqualOrNotFinite) {
  PointCloud source = MovedCorner(1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Eigen::Vector3f& normal : {Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(nan, nan, nan)}) {
    source.normals.assign(source.points.size(), normal);
    WritePly(source, Source());
    const ProgramResult result = Succeeded(Register(Source(), Target()));
    EXPECT_THAT(result.out,
                ::testing::ContainsRegex("source: 12000 points, normals from a radius"));
    EXPECT_THAT(ParseTransform(ReadBytes(Output("transform.txt"))),
                RigidNear(Truth(), kTolerance_m, kTolerance_rad));
  }
}

TEST_F(RegisterTool, RegistersCloudsInMillimetres) {
  for (const auto& [path, metres] :
       {std::pair(Source(), MovedCorner(1)), std::pair(Target(), Corner(2))}) {
    PointCloud cloud = metres;
    for (Eigen::Vector3f& point : cloud.points) point *= 1000;
    WritePly(cloud, path);
  }
  const ProgramResult result = Succeeded(Register(Source(), Target()));
  EXPECT_THAT(result.out, ::testing::HasSubstr("coordinates should be in metres"));
  Rigid3d pose = ParseTransform(ReadBytes(Output("transform.txt")));
  pose.translation /= 1000;
  EXPECT_THAT(pose, RigidNear(Truth(), kTolerance_m, kTolerance_rad));
}

TEST_F(RegisterTool, RejectsBadInputInOneLine) {
  const std::string empty = folder_ / "empty.ply";
  WritePly({}, empty);
  const std::tuple<std::string, RunFlags, std::vector<std::string>> cases[] = {
      {Source(), {"--target="}, {"--target"}},
      {"/no/such.pcd", {}, {"/no/such.pcd"}},
      {empty, {}, {empty}},
      {Source(), {"--association=projective"}, {"association", "projective", "kd_tree"}},
      {Source(), {"--start=magic"}, {"--start", "magic", "identity", "global", "auto"}},
      {Source(), {"--start=/no/pose.txt"}, {"--start", "/no/pose.txt"}},
      {Source(), {"--start=0,0,0"}, {"start_pose", "0,0,0"}},
      {Source(), {"--start_pose=0,0,0,0,0,0,1"}, {"--start_pose", "--start=POSE"}},
      {Source(), {"--solver=magic"}, {"solver", "magic", "closed_form_ldlt"}},
      {Source(), {"--solver=svd"}, {"svd"}},
      {Source(), {"--pyramid_levels=3"}, {"pyramid_levels"}}};
  for (const auto& [source, flags, names] : cases)
    ExpectRefused(Register(source, Target(), flags), NamesMatcher(names));
}

// A simulated walk at 160 x 120 pixels, shared by all tests.
class AlignTool : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    Succeeded(
        RunProgram("surfit_simulate", {"--output=" + Room(), "--frames=6", "--downsample=4"}));
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string Room() { return folder_->path() + "/room"; }
  ProgramResult Align(const std::string& sequence, std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"--sequence=" + sequence, "--output=" + (own_ / "out")});
    return RunProgram("surfit_align", flags);
  }

  static TempFolder* folder_;
  TempFolder own_;
};

TempFolder* AlignTool::folder_ = nullptr;

TEST_F(AlignTool, PrintsEachIterationAndWritesCloudsAndPictures) {
  const ProgramResult result = Succeeded(Align(Room(), {"--pair=0,2"}));
  EXPECT_THAT(result.out,
              AllOf(ContainsRegex("iter 0: avg loss = [0-9.]+e[-+][0-9]+, inlier count = [0-9]+\n"),
                    Names("converged", "pose")));
  for (const char* name : {"before", "after"}) {
    const PointCloud cloud = ReadPly(own_ / "out" + "/" + name + ".ply");
    EXPECT_GT(cloud.points.size(), 20000u);  // most pixels of two images with 19,200 pixels
    EXPECT_EQ(cloud.colors.size(), cloud.points.size());
    EXPECT_THAT(ReadBytes(own_ / "out" + "/" + name + ".png"), StartsWith("\x89PNG"));
  }
}

TEST_F(AlignTool, WritesPoseAndCovariance) {
  Succeeded(Align(Room(), {"--pair=0,5", "--start=features"}));
  const std::string folder = own_ / "out" + "/";
  const Rigid3d pose = ParseTransform(ReadBytes(folder + "transform.txt"));
  const auto json = nlohmann::json::parse(ReadBytes(folder + "registration.json"));
  const Eigen::Matrix4d matrix = pose.Matrix();
  for (int i = 0; i < 16; ++i) {
    EXPECT_NEAR(json["target_from_source"][i / 4][i % 4], matrix(i / 4, i % 4), 1e-12);
  }
  EXPECT_EQ(json["succeeded"], true);
  EXPECT_EQ(json["start"], "features");
  EXPECT_GT(json["verification"]["overlap_ratio"], 0.5);
  ASSERT_EQ(json["covariance"].size(), 6u);
  const double sigma_m = std::sqrt(json["covariance"][5][5].get<double>());
  EXPECT_GT(sigma_m, 1e-5);
  EXPECT_LT(sigma_m, 0.01);
  EXPECT_LT(json["pose_error"]["after"]["m"], 0.008);
  EXPECT_GT(json["pose_error"]["before"]["m"], 0.05);
  EXPECT_EQ(json["options"]["start"], "features");
}

TEST_F(AlignTool, FailsWithValueAndConstraint) {
  const ProgramResult few = Align(Room(), {"--pair=0,5", "--max_distance_m=0.00001"});
  EXPECT_EQ(few.exit_code, 2);
  EXPECT_THAT(WithoutNotes(few.err),
              AllOf(StartsWith("failed: too_few_inliers: "), Names("min_inliers", 200)));
}

TEST_F(AlignTool, FlagsOverrideThePreset) {
  const ProgramResult help = RunProgram("surfit_align", {"--helpon=registration"});
  EXPECT_THAT(help.out, Names("--max_distance_m=0.05"));
  const ProgramResult strict = Align(Room(), {"--pair=0,1", "--max_distance_m=0.0001"});
  EXPECT_EQ(strict.exit_code, 2);
  EXPECT_THAT(WithoutNotes(strict.err), StartsWith("failed: too_few_inliers"));
}

TEST_F(AlignTool, RejectsBadInputInOneLine) {
  const RefusedFlags cases = {
      {{"--pair=-1,1"}, {"--pair", "source_frame", "-1"}},
      {{"--pair=0,6"}, {"6"}},
      {{"--max_normal_angle_deg=-1"}, {"--max_normal_angle_deg", "-1"}},
      {{"--max_free_space_violation_ratio=2"}, {"max_free_space_violation_ratio", "0.2"}},
      {{"--solver=magic"}, {"solver", "magic", "closed_form_ldlt"}},
      {{"--start=magic"}, {"start", "magic", "identity", "features"}},
      {{"--nonsense=1"}, {"nonsense"}},
  };
  for (const auto& [flags, names] : cases) ExpectRefused(Align(Room(), flags), NamesMatcher(names));
  ExpectRefused(Align(own_ / "nowhere", {}), "nowhere");
}

TEST_F(AlignTool, StartsFromFeaturesAndPrintsTheVerification) {
  const ProgramResult result = Succeeded(Align(Room(), {"--pair=0,5", "--start=features"}));
  EXPECT_THAT(result.out, ContainsRegex("overlap [a-z]+ 0\\.[0-9]+.* correlation .*0\\.[0-9]+"));
  // The motion is 14 mm per frame. The pose error is below one pixel, 8 mm at 1 m.
  EXPECT_THAT(result.out, ContainsRegex("error:? 0\\.00[0-7][0-9] m.* 0\\.0[4-9]"));
}

// The motion is too large for ICP from the identity. The failure must be reported.
TEST_F(AlignTool, ReportsFailureOfLargeMotions) {
  SURFIT_REQUIRE_SHARED_DATA("icl_office");
  for (const char* pair : {"--pair=10,50", "--pair=10,100"}) {
    const ProgramResult result = Align(SharedData("icl_office"), {pair});
    EXPECT_EQ(result.exit_code, 2) << pair;
    EXPECT_THAT(result.out, Not(ContainsRegex("(^|\n)converged: "))) << pair;
    EXPECT_THAT(WithoutNotes(result.err), StartsWith("failed: ")) << pair;
  }
}

// The motion is 52 cm and 17 degrees. ICP from the identity has errors of 34 to 67 cm with every
// residual. The ground truth has an error of centimetres over this distance.
TEST_F(AlignTool, FeaturesRegisterFramesFarApart) {
  SURFIT_REQUIRE_SHARED_DATA("seven_scenes_kitchen");
  const ProgramResult result =
      Succeeded(Align(SharedData("seven_scenes_kitchen"), {"--pair=10,100", "--start=features"}));
  EXPECT_THAT(result.out, ContainsRegex("error:? 0\\.0[0-5]"));
}

}  // namespace
}  // namespace surfit::testing
