// Results of runs that end with an exception.
#include <gmock/gmock.h>

#include <atomic>
#include <new>
#include <nlohmann/json.hpp>

#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/run/slam_run.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

class SavedRun : public ::testing::Test {
 protected:
  void SetUp() override {
    WriteTumSequence(sequence_, 6);
    options_.sequence = Options(sequence_);
    options_.output = output_.path() + "/out";
    options_.pictures = false;
  }

  // Runs until `at_third_frame` throws. Expects saved results, and an error with the names.
  template <typename... Parts>
  void ExpectSaved(const std::function<void()>& at_third_frame, const Parts&... names) {
    ExpectInputError(
        [&] {
          RunSlam(options_, false, [&](const SlamRunProgress& progress) {
            if (progress.frames_done == 3) at_third_frame();
          });
        },
        Names(names...));
    const auto summary = nlohmann::json::parse(ReadBytes(options_.output + "/summary.json"));
    EXPECT_THAT(summary["failure"].get<std::string>(), Names(names...));
    EXPECT_EQ(summary["frames_total"], 3);
    EXPECT_THAT(ReadBytes(options_.output + "/frames.csv"), ContainsRegex("\n2,"));
    EXPECT_FALSE(std::filesystem::exists(options_.output + "/.surfit.lock"));
  }

  TempFolder sequence_, output_;
  SlamRunOptions options_;
};

TEST_F(SavedRun, SavesResultsAfterBadAlloc) {
  ExpectSaved([] { throw std::bad_alloc(); }, "max_map_points");
  EXPECT_NO_THROW(ReadPly(options_.output + "/map.ply"));
  EXPECT_NO_THROW(ReadTumTrajectory(options_.output + "/trajectory.txt"));
}

TEST_F(SavedRun, SavesResultsAfterAnUnknownException) {
  ExpectSaved([] { throw 7; }, "unknown");
}

TEST_F(SavedRun, NamesEachFailureOnce) {
  ExpectSaved(
      [&] {
        std::filesystem::create_directory(options_.output + "/map.ply");
        throw InputError("first");
      },
      "first", options_.output + "/map.ply");
}

}  // namespace
}  // namespace surfit::testing
