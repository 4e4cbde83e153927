// Runs that something ends, and what they save.
#include <gmock/gmock.h>

#include <atomic>
#include <new>

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

  // Runs until `at_third_frame` throws.
  void ExpectSaved(const std::function<void()>& at_third_frame, const std::string& message) {
    ExpectInputError(
        [&] {
          RunSlam(options_, false, [&](const SlamRunProgress& progress) {
            if (progress.frames_done == 3) at_third_frame();
          });
        },
        HasSubstr(message));
    EXPECT_THAT(ReadBytes(options_.output + "/summary.json"),
                AllOf(HasSubstr("\"failure\": \"" + message), HasSubstr("\"frames_total\": 3")));
    EXPECT_THAT(ReadBytes(options_.output + "/frames.csv"), HasSubstr("\n2,"));
    EXPECT_FALSE(std::filesystem::exists(options_.output + "/.surfit.lock"));
  }

  TempFolder sequence_, output_;
  SlamRunOptions options_;
};

TEST_F(SavedRun, OutlivesMemory) {
  ExpectSaved([] { throw std::bad_alloc(); }, "memory is exhausted: max_map_points bounds the map");
  EXPECT_NO_THROW(ReadPly(options_.output + "/map.ply"));
  EXPECT_NO_THROW(ReadTumTrajectory(options_.output + "/trajectory.txt"));
}

TEST_F(SavedRun, OutlivesWhatIsNoException) {
  ExpectSaved([] { throw 7; }, "unknown");
}

TEST_F(SavedRun, NamesAllThatFailedOnce) {
  ExpectSaved(
      [&] {
        std::filesystem::create_directory(options_.output + "/map.ply");
        throw InputError("first");
      },
      "first; cannot write '" + options_.output + "/map.ply'");
}

}  // namespace
}  // namespace surfit::testing
