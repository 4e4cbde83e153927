#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>

#include "report/report_data.h"
#include "surfit/io/point_cloud.h"
#include "surfit/report/write_report.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Surfels at x = 0, 1, ..., count - 1 metres.
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

TEST(PackMap, HoldsEverySurfelOfASmallMap) {
  const auto packed = PackMap(Row(2), 10);
  EXPECT_EQ(packed["points"], 2);
  EXPECT_EQ(packed["shown"], 2);
  EXPECT_EQ(packed["origin"], (std::vector<float>{0, 2, -3}));
  EXPECT_EQ(packed["extent"][0], 1);
  EXPECT_FLOAT_EQ(packed["radius"].get<float>(), 0.01f);
  // The share of an extent of nothing is 0, rounded: 0.5 is cut off.
  EXPECT_EQ(packed["position"], EncodeBase64(std::vector<std::uint16_t>{0, 0, 0, 65535, 0, 0}));
  EXPECT_EQ(packed["normal"], EncodeBase64(std::vector<std::int8_t>{0, -127, 0, 0, -127, 0}));
  EXPECT_EQ(packed["color"], EncodeBase64(std::vector<std::uint8_t>{10, 20, 0, 10, 20, 1}));
  EXPECT_EQ(packed["confidence"], EncodeBase64(std::vector<float>{5.5f, 5.5f}));
  EXPECT_EQ(packed["first_seen"], EncodeBase64(std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(packed["last_seen"], EncodeBase64(std::vector<std::int32_t>{0, 2}));
}

TEST(PackMap, ThinsOutEvenly) {
  const auto packed = PackMap(Row(100), 4);
  EXPECT_EQ(packed["points"], 100);
  EXPECT_EQ(packed["shown"], 4);
  EXPECT_EQ(packed["first_seen"], EncodeBase64(std::vector<std::int32_t>{0, 50, 25, 75}));
}

// Base64's digits of whole 32-bit numbers.
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

// While the widest gap is g (a power of two), multiples of g / 2 were taken only: at most
// 1 + count / (g / 2) of them.
TEST(PackMap, BeginsWithAnEvenShare) {
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
      EXPECT_GE(gap, 1) << "each is taken once";
      EXPECT_LE(gap, 2 * count / (taken - 1)) << taken;
    }
  }
}

TEST(PackMap, LeavesOutWhatIsNotFinite) {
  auto surfels = Row(3);
  surfels[1].position_in_world.y() = std::numeric_limits<float>::quiet_NaN();
  const auto packed = PackMap(surfels, 10);
  EXPECT_EQ(packed["points"], 3);
  EXPECT_EQ(packed["shown"], 2);
}

TEST(PackMap, TakesAnEmptyMap) {
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
  // 111110 111111 111110 111111 in bits.
  EXPECT_EQ(EncodeBase64(std::string("\xfb\xff\xbf")), "+/+/");
}

TEST(EncodeBase64, WritesNumbersLittleEndian) {
  EXPECT_EQ(EncodeBase64(std::vector<std::uint16_t>{0x6f66, 0x666f}),
            EncodeBase64(std::string("foof")));
}

// The least that a run's folder holds.
class WriteReportTest : public ::testing::Test {
 protected:
  WriteReportTest() {
    SurfelMap map;
    map.Append(Surfel());
    WriteSurfelPly(map, folder_ / "run/map.ply");
    folder_.Write("run/summary.json", R"({"options": {"sequence": "</script><b>"}})");
    folder_.Write("run/frames.csv", "index,state\n0,first\n");
    folder_.Write("run/poses.json",
                  R"({"views": [{"index": 0, "files": {"input_color": "v.jpg"}}]})");
    folder_.Write("run/v.jpg", "foobar");
    options_.runs = {folder_ / "run"};
    options_.output = folder_ / "report.html";
  }

  TempFolder folder_;
  ReportOptions options_;
};

TEST_F(WriteReportTest, HoldsTheRunAndSaysHowMuchOfTheMap) {
  const std::vector<ReportedMap> maps = WriteReport(options_);
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].points, 1u);
  EXPECT_EQ(maps[0].shown_points, 1u);
  const std::string page = ReadBytes(options_.output);
  EXPECT_THAT(page, HasSubstr("data:image/jpeg;base64,Zm9vYmFy"));
  EXPECT_THAT(page, HasSubstr("index,state\\n0,first\\n"));
}

TEST_F(WriteReportTest, TellsHowTheViewsWereJudged) {
  WriteReport(options_);
  EXPECT_THAT(ReadBytes(options_.output), Not(HasSubstr("judged_views")));
  folder_.Write("run/views.json", R"({"psnr_covered_db": 21.5})");
  WriteReport(options_);
  EXPECT_THAT(ReadBytes(options_.output), HasSubstr(R"("judged_views":{"psnr_covered_db":21.5})"));
}

TEST_F(WriteReportTest, NoTextOfTheRunEndsItsElement) {
  WriteReport(options_);
  const std::string page = ReadBytes(options_.output);
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cb>"));
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));
}

TEST_F(WriteReportTest, SaysWhatThePosesLack) {
  folder_.Write("run/poses.json", "{}");
  ExpectInputError([&] { WriteReport(options_); }, HasSubstr("poses.json: incomplete"));
}

TEST_F(WriteReportTest, RefusesWhatIsNoRun) {
  options_.runs.push_back(folder_.path());
  ExpectInputError([&] { WriteReport(options_); }, HasSubstr("summary.json"));
  EXPECT_FALSE(std::filesystem::exists(options_.output));
  options_.runs.pop_back();
  folder_.Write("run/summary.json", "[]");
  ExpectInputError([&] { WriteReport(options_); }, HasSubstr("summary.json must be a JSON object"));
  folder_.Write("run/summary.json", std::string(100000, '[') + std::string(100000, ']'));
  ExpectInputError([&] { WriteReport(options_); }, HasSubstr("summary.json is nested too deeply"));
}

}  // namespace
}  // namespace surfit::testing
