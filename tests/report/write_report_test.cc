#include "surfit/report/write_report.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "surfit/io/point_cloud.h"
#include "testing/expect_input_error.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

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
}

}  // namespace
}  // namespace surfit::testing
