#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>

#include "output/report/compare_runs.h"
#include "output/report/report_data.h"
#include "output/report/write_report.h"
#include "surfit/io/point_cloud.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Surfels at x = 0, 1, ..., count - 1 m.
std::vector<Surfel> Row(int count) {
  std::vector<Surfel> surfels(count);
  for (int i = 0; i < count; ++i) {
    surfels[i].position_in_world = {static_cast<float>(i), 2.f, -3.f};
    surfels[i].normal_in_world = {0.f, -1.f, 0.f};
    surfels[i].color = {10, 20, static_cast<std::uint8_t>(i)};
    surfels[i].radius_m = 0.01f;
    surfels[i].confidence = 5.5f;
    surfels[i].first_seen = i;
    surfels[i].last_seen = 2 * i;
  }
  return surfels;
}

TEST(PackMap, ContainsEverySurfelOfASmallMap) {
  const auto packed = PackMap(Row(2), 10);
  EXPECT_EQ(packed["points"], 2);
  EXPECT_EQ(packed["shown"], 2);
  EXPECT_EQ(packed["origin"], (std::vector<float>{0, 2, -3}));
  EXPECT_EQ(packed["extent"][0], 1);
  EXPECT_FLOAT_EQ(packed["max_radius"].get<float>(), 0.01f);
  EXPECT_EQ(packed["radius"], EncodeBase64(std::vector<std::uint16_t>{65535, 65535}));
  // Positions are relative to the extent of the map. If the extent is 0, they are 0.
  EXPECT_EQ(packed["position"], EncodeBase64(std::vector<std::uint16_t>{0, 0, 0, 65535, 0, 0}));
  EXPECT_EQ(packed["normal"], EncodeBase64(std::vector<std::int8_t>{0, -127, 0, 0, -127, 0}));
  EXPECT_EQ(packed["color"], EncodeBase64(std::vector<std::uint8_t>{10, 20, 0, 10, 20, 1}));
  EXPECT_EQ(packed["confidence"], EncodeBase64(std::vector<float>{5.5f, 5.5f}));
  EXPECT_EQ(packed["first_seen"], EncodeBase64(std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(packed["last_seen"], EncodeBase64(std::vector<std::int32_t>{0, 2}));
}

TEST(PackMap, SubsamplesEvenly) {
  const auto packed = PackMap(Row(100), 4);
  EXPECT_EQ(packed["points"], 100);
  EXPECT_EQ(packed["shown"], 4);
  EXPECT_EQ(packed["first_seen"], EncodeBase64(std::vector<std::int32_t>{0, 50, 25, 75}));
}

// Decodes Base64 to 32-bit integers.
std::vector<std::int32_t> DecodeNumbers(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  int bits = 0, filled = 0;
  for (const char c : text.substr(0, text.find('='))) {
    bits = (bits << 6 | static_cast<int>(digits.find(c))) & 0xffff;
    filled += 6;
    if (filled >= 8) bytes += static_cast<char>(bits >> (filled -= 8));
  }
  std::vector<std::int32_t> numbers(bytes.size() / 4);
  std::memcpy(numbers.data(), bytes.data(), 4 * numbers.size());
  return numbers;
}

// If the largest gap is g (a power of two), only multiples of g / 2 were selected: at most
// 1 + count / (g / 2).
TEST(PackMap, BeginsWithAnEvenSubset) {
  const int count = 1000;
  const std::string first_seen = PackMap(Row(count), count)["first_seen"];
  const std::vector<std::int32_t> order = DecodeNumbers(first_seen);
  ASSERT_EQ(order.size(), static_cast<std::size_t>(count));
  for (const int taken : {10, 77, 400, 1000}) {
    std::vector<std::int32_t> first(order.begin(), order.begin() + taken);
    first.push_back(count);
    std::sort(first.begin(), first.end());
    EXPECT_EQ(first[0], 0);
    for (int i = 0; i < taken; ++i) {
      const int gap = first[i + 1] - first[i];
      EXPECT_GE(gap, 1) << "a surfel is selected twice";
      EXPECT_LE(gap, 2 * count / (taken - 1)) << taken;
    }
  }
}

TEST(PackMap, SkipsNonFiniteSurfels) {
  auto surfels = Row(3);
  surfels[1].position_in_world.y() = std::numeric_limits<float>::quiet_NaN();
  const auto packed = PackMap(surfels, 10);
  EXPECT_EQ(packed["points"], 3);
  EXPECT_EQ(packed["shown"], 2);
}

TEST(PackMap, StoresRadiiRelativeToTheLargest) {
  auto surfels = Row(2);
  surfels[1].radius_m = 0.0025f;
  EXPECT_EQ(PackMap(surfels, 10)["radius"],
            EncodeBase64(std::vector<std::uint16_t>{65535, 65535 / 4 + 1}));
}

TEST(PackMap, AcceptsAnEmptyMap) {
  const auto packed = PackMap({}, 10);
  EXPECT_EQ(packed["shown"], 0);
  EXPECT_EQ(packed["position"], "");
}

// RFC 4648, section 10.
TEST(EncodeBase64, EncodesTheVectorsOfTheStandard) {
  EXPECT_EQ(EncodeBase64(std::string()), "");
  EXPECT_EQ(EncodeBase64(std::string("f")), "Zg==");
  EXPECT_EQ(EncodeBase64(std::string("fo")), "Zm8=");
  EXPECT_EQ(EncodeBase64(std::string("foo")), "Zm9v");
  EXPECT_EQ(EncodeBase64(std::string("foobar")), "Zm9vYmFy");
}

TEST(EncodeBase64, EncodesAllDigits) {
  // The bits are 111110 111111 111110 111111.
  EXPECT_EQ(EncodeBase64(std::string("\xfb\xff\xbf")), "+/+/");
}

TEST(EncodeBase64, WritesNumbersLittleEndian) {
  EXPECT_EQ(EncodeBase64(std::vector<std::uint16_t>{0x6f66, 0x666f}),
            EncodeBase64(std::string("foof")));
}

TEST(PackDistances, UsesUnitsOfATenthOfAMillimetre) {
  EXPECT_EQ(PackDistances({0, 0.00012f, 0.1f, kFarFromMap}),
            EncodeBase64(std::vector<std::uint16_t>{0, 1, 1000, 65535}));
}

TEST(ShortNames, AreTheLastDifferentParts) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(ShortNames({"/home/someone/out"}), Names{"out"});
  EXPECT_EQ(ShortNames({"/a/plane/", "/b/./curved"}), (Names{"plane", "curved"}));
  EXPECT_EQ(ShortNames({"/a/one/out", "/a/two/out"}), (Names{"one/out", "two/out"}));
  EXPECT_EQ(ShortNames({"/a/out", "/a/out"}), (Names{"out", "out"}));
  EXPECT_EQ(ShortNames({"."}), Names{std::filesystem::current_path().filename().string()});
}

// Poses at 10 Hz along a line, or around a corner if `turns`.
Trajectory Path(int poses, bool turns) {
  Trajectory path;
  for (int i = 0; i < poses; ++i) {
    const Eigen::Vector3d place(0.1 * i, turns && i > poses / 2 ? 0.2 * i : 0, 0);
    path.push_back({0.1 * i, {Eigen::Quaterniond::Identity(), place}});
  }
  return path;
}

const Rigid3d kElsewhere(Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())),
                         {1, -2, 3});

Trajectory Moved(Trajectory path, const Rigid3d& by) {
  for (StampedPose& pose : path) pose.world_from_camera = by * pose.world_from_camera;
  return path;
}

// The data are exact up to rounding.
TEST(AlignRuns, EstimatesTheTransformBetweenTheWorldFrames) {
  for (const bool turns :
       {true, false}) {  // positions on a line do not constrain the rotation about it
    const Trajectory path = Path(10, turns);
    const auto alignment = AlignRuns(path, Moved(path, kElsewhere));
    ASSERT_TRUE(alignment);
    EXPECT_EQ(alignment->poses, 10u);
    EXPECT_LT(alignment->rms_m, 1e-9);
    EXPECT_LT((alignment->target_from_source.Matrix() - kElsewhere.Matrix()).norm(), 1e-9) << turns;
  }
}

TEST(AlignRuns, NeedsThreePosesOfEqualTimes) {
  EXPECT_FALSE(AlignRuns(Path(2, true), Path(10, true)));
  Trajectory later = Path(10, true);
  for (StampedPose& pose : later) pose.stamp_s += 100;
  EXPECT_FALSE(AlignRuns(later, Path(10, true)));
}

// The map is a row of discs with a radius of 1 cm and normal -y, 1 m apart along x, at y = 2, z =
// -3.
TEST(DistancesFromMap, AreFromTheClosestDisc) {
  std::vector<Surfel> surfels = Row(4);
  surfels[1].position_in_world += Eigen::Vector3f(0.005f, 0.1f, 0);  // above the disc
  surfels[2].position_in_world += Eigen::Vector3f(0.04f, 0.04f, 0);  // beside it: 3 and 4 cm
  surfels[3].position_in_world.y() += 0.6f;
  const Rigid3d moved(Eigen::Quaterniond::Identity(), {0, 0, 10});
  for (Surfel& surfel : surfels) surfel.position_in_world.z() -= 10;
  const std::vector<float> distances = DistancesFromMap(surfels, moved, Row(4));
  // Single precision rounds coordinates of 10 m to 1 um.
  EXPECT_NEAR(distances[0], 0, 2e-6);
  EXPECT_NEAR(distances[1], 0.1, 2e-6);
  EXPECT_NEAR(distances[2], 0.05, 2e-6);
  EXPECT_EQ(distances[3], kFarFromMap);
  EXPECT_EQ(DistancesFromMap(Row(1), {}, {}), std::vector<float>{kFarFromMap});
}

// The minimum contents of a run folder.
class WriteReportTest : public ::testing::Test {
 protected:
  WriteReportTest() {
    SurfelMap map;
    map.Append(Surfel());
    WriteSurfelPly(map, folder_ / "run/map.ply");
    folder_.Write("run/summary.json", R"({"options": {"sequence": "</script><b>"}})");
    folder_.Write("run/frames.csv", "index,state\n0,first\n");
    folder_.Write("run/poses.json",
                  R"({"views": [{"index": 0, "files": {"input_color": "v.jpg"}}], "poses": []})");
    folder_.Write("run/v.jpg", "foobar");
    options_.runs = {folder_ / "run"};
    options_.output = folder_ / "report.html";
  }

  TempFolder folder_;
  ReportOptions options_;
};

TEST_F(WriteReportTest, ContainsTheRun) {
  const std::vector<ReportedMap> maps = WriteReport(options_);
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].points, 1u);
  EXPECT_EQ(maps[0].shown_points, 1u);
  const std::string page = ReadBytes(options_.output);
  EXPECT_THAT(page, Names("data:image/jpeg;base64,Zm9vYmFy"));
  EXPECT_THAT(page, Names("index,state\\n0,first\\n"));
}

TEST_F(WriteReportTest, ContainsTheEvaluationOfViews) {
  WriteReport(options_);
  EXPECT_THAT(ReadBytes(options_.output), Not(Names("judged_views")));
  folder_.Write("run/views.json", R"({"psnr_covered_db": 21.5})");
  WriteReport(options_);
  EXPECT_THAT(ReadBytes(options_.output), Names(R"("judged_views":{"psnr_covered_db":21.5})"));
}

TEST_F(WriteReportTest, EscapesTextOfTheRun) {
  WriteReport(options_);
  const std::string page = ReadBytes(options_.output);
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cb>"));
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));
}

TEST_F(WriteReportTest, NamesRunsWithoutTheirPath) {
  WriteReport(options_);
  const std::string page = ReadBytes(options_.output);
  EXPECT_THAT(page, Names(R"("label":"run")"));
  EXPECT_THAT(page, Not(HasSubstr(folder_.path())));
}

TEST_F(WriteReportTest, ContainsTheLoops) {
  folder_.Write("run/loops.csv", "source,target,reason\n9,2,poor_fit\n");
  WriteReport(options_);
  EXPECT_THAT(ReadBytes(options_.output),
              Names(R"("loops":"source,target,reason\n9,2,poor_fit\n")"));
}

TEST_F(WriteReportTest, SubsamplesThumbnails) {
  std::string thumbnails;
  for (int i = 0; i < 200; ++i) {
    thumbnails += (i > 0 ? "," : "") + (R"({"index":)" + std::to_string(i)) +
                  R"(,"files":{"input_color":"v.jpg"}})";
  }
  folder_.Write("run/poses.json",
                R"({"views": [], "poses": [], "thumbnails": [)" + thumbnails + "]}");
  WriteReport(options_);
  const std::string page = ReadBytes(options_.output);
  int pictures = 0;
  for (std::size_t at = 0; (at = page.find("Zm9vYmFy", at)) != std::string::npos; ++at) ++pictures;
  EXPECT_EQ(pictures, 100);  // every second picture
}

TEST_F(WriteReportTest, AcceptsARefinedRun) {
  std::filesystem::remove(folder_ / "run/summary.json");
  std::filesystem::remove(folder_ / "run/frames.csv");
  folder_.Write("run/refinement.json", R"({"termination": "converged", "options": {}})");
  WriteReport(options_);
  const std::string page = ReadBytes(options_.output);
  EXPECT_THAT(page, Names(R"("summary":{"termination":"converged")"));
  EXPECT_THAT(page, Names(R"("frames":"")"));
}

TEST_F(WriteReportTest, ComparesRunsOfEqualTimes) {
  const char* const poses = R"({"views": [], "poses": [[0, 0, 0, 0, 0, 0, 0, 0, 1],
      [1, 1, 1, 0, 0, 0, 0, 0, 1], [2, 2, 1, 1, 0, 0, 0, 0, 1]]})";
  folder_.Write("run/poses.json", poses);
  WriteReport(options_);
  EXPECT_THAT(ReadBytes(options_.output), Not(Names(R"("compared_with":)")));  // one run
  std::filesystem::copy(folder_ / "run", folder_ / "other");
  options_.runs.push_back(folder_ / "other");
  WriteReport(options_);
  const std::string page = ReadBytes(options_.output);
  EXPECT_THAT(page, Names(R"("compared_with":"other")"));
  EXPECT_THAT(page, Names(R"("compared_with":"run")"));
  EXPECT_THAT(page, Names(R"("distance":"AAA=")"));  // one surfel with distance 0
  folder_.Write("other/poses.json", R"({"views": [], "poses": []})");
  WriteReport(options_);
  EXPECT_THAT(ReadBytes(options_.output), Not(Names(R"("compared_with":)")));
}

TEST_F(WriteReportTest, RejectsMalformedPoses) {
  folder_.Write("run/poses.json", "{}");
  ExpectInputError([&] { WriteReport(options_); }, Names("poses.json"));
  folder_.Write("run/poses.json", R"({"views": [], "poses": [[0, 0, 1e200, 0, 0, 0, 0, 0, 1]]})");
  ExpectInputError([&] { WriteReport(options_); }, Names("poses.json"));
  folder_.Write("run/poses.json", R"({"views": [], "poses": [], "thumbnails": 7})");
  ExpectInputError([&] { WriteReport(options_); }, Names("poses.json"));
}

TEST_F(WriteReportTest, RejectsFoldersWithoutRun) {
  options_.runs.push_back(folder_.path());
  ExpectInputError([&] { WriteReport(options_); }, Names("summary.json"));
  EXPECT_FALSE(std::filesystem::exists(options_.output));
  options_.runs.pop_back();
  folder_.Write("run/summary.json", "[]");
  ExpectInputError([&] { WriteReport(options_); }, Names("summary.json"));
  folder_.Write("run/summary.json", std::string(100000, '[') + std::string(100000, ']'));
  ExpectInputError([&] { WriteReport(options_); }, Names("summary.json"));
}

}  // namespace
}  // namespace surfit::testing
