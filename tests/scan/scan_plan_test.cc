#include "apps/scan/scan_plan.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Fragments contain all frames, have the required overlap, at most the maximum length, and similar
// lengths.
TEST(CutIntoFragments, CoversAllFramesWithTheRequiredOverlap) {
  constexpr int kFirst = 7, kLength = 50;
  for (const int stride : {1, 3}) {
    for (const int overlap : {0, 1, 10}) {
      for (int frames = 1; frames < 300; ++frames) {
        const auto cut = CutIntoFragments(kFirst, frames, stride, kLength, overlap);
        EXPECT_EQ(cut.front().first, kFirst);
        EXPECT_EQ(cut.back().last, kFirst + stride * (frames - 1));
        for (std::size_t i = 0; i < cut.size(); ++i) {
          const int length = (cut[i].last - cut[i].first) / stride + 1;
          EXPECT_LE(length, kLength);
          if (i == 0) continue;
          EXPECT_EQ(cut[i - 1].last - cut[i].first, stride * (overlap - 1));
          EXPECT_GE(length, (kLength - overlap) / 2);
        }
      }
    }
  }
}

TEST(CutIntoFragments, CreatesTheFewestFragmentsAndNumbersThem) {
  EXPECT_EQ(CutIntoFragments(0, 50, 1, 50, 10).size(), 1u);
  EXPECT_EQ(CutIntoFragments(0, 51, 1, 50, 10).size(), 2u);
  const auto three = CutIntoFragments(0, 130, 1, 50, 10);
  ASSERT_EQ(three.size(), 3u);
  EXPECT_EQ(three[2].name, "0002");
}

TEST(CutIntoFragments, RejectsAnEmptyRange) {
  EXPECT_THROW(CutIntoFragments(0, 0, 1, 50, 10), InputError);
}

class PlanScanTest : public ::testing::Test {
 protected:
  PlanScanTest() {
    WriteTumSequence(sequence_, 12);
    options_.sequences = {sequence_.path()};
    options_.run.output = scan_.path();
    options_.fragment_frames = 5;
    options_.overlap_frames = 2;
  }

  const TempFolder sequence_, scan_;
  ScanPlanOptions options_;
};

TEST_F(PlanScanTest, RejectsOverlapOfAFullFragment) {
  options_.overlap_frames = 5;
  EXPECT_THROW(PlanScan(options_), InputError);
}

TEST_F(PlanScanTest, WritesFragmentsAndTheirFlags) {
  options_.run.sequence.first = 1;
  options_.run.sequence.stride = 2;
  options_.pictures = false;
  PlanScan(options_);
  const ScanPlan plan = ReadScanPlan(scan_.path());
  // Frames 1 3 5 7 9 11 with an overlap of two frames.
  ASSERT_EQ(plan.fragments.size(), 2u);
  EXPECT_EQ(plan.fragments[0].first, 1);
  EXPECT_EQ(plan.fragments[0].last, 7);
  EXPECT_EQ(plan.fragments[1].first, 5);
  EXPECT_EQ(plan.fragments[1].last, 11);
  EXPECT_EQ(plan.recordings[0].stride, 2);
  EXPECT_EQ(plan.tile_m, options_.tile_m);
  EXPECT_FALSE(plan.pictures);
  const std::string flags = ReadBytes(scan_ / "fragments/0001.flags");
  for (const char* const flag : {"--first=5", "--last=11", "--stride=2", "--keep_places=true",
                                 "--calibrate=false", "--new_map_after=0"}) {
    EXPECT_THAT(flags, Names(flag));
  }
  EXPECT_THAT(flags, ::testing::Not(::testing::HasSubstr("loop_closure")))
      << "the default closes loops";
  EXPECT_THAT(ReadBytes(scan_ / "camera_0.flags"), Names("--last=1199", "--loop_closure=false"));
}

TEST_F(PlanScanTest, CutsEachRecordingSeparately) {
  const TempFolder other;
  WriteTumSequence(other, 7);
  const std::string path = std::filesystem::path(other.path()).lexically_normal();
  options_.sequences.push_back(path);
  PlanScan(options_);
  const ScanPlan plan = ReadScanPlan(scan_.path());
  ASSERT_EQ(plan.recordings.size(), 2u);
  EXPECT_EQ(plan.recordings[1].path, path);
  // Four fragments of 12 frames, and two fragments of 7 frames.
  ASSERT_EQ(plan.fragments.size(), 6u);
  EXPECT_EQ(plan.fragments[3].recording, 0);
  EXPECT_EQ(plan.fragments[3].last, 11);
  EXPECT_EQ(plan.fragments[4].name, "0004");
  EXPECT_EQ(plan.fragments[4].recording, 1);
  EXPECT_EQ(plan.fragments[4].first, 0);
  EXPECT_EQ(plan.fragments[5].last, 6);
  EXPECT_THAT(ReadBytes(scan_ / "fragments/0004.flags"), Names("--sequence=" + path));
  EXPECT_THAT(ReadBytes(scan_ / "camera_1.flags"), Names("--sequence=" + path));
}

TEST_F(PlanScanTest, RejectsDuplicateRecordings) {
  options_.sequences.push_back(sequence_.path());
  EXPECT_THROW(PlanScan(options_), InputError);
}

TEST_F(PlanScanTest, DoesNotRewriteUnchangedFiles) {
  PlanScan(options_);
  const auto time = std::filesystem::last_write_time(scan_ / "plan.json");
  const auto fragment = std::filesystem::last_write_time(scan_ / "fragments/0000.flags");
  PlanScan(options_);
  EXPECT_EQ(std::filesystem::last_write_time(scan_ / "plan.json"), time);
  options_.tile_m = 2;
  PlanScan(options_);
  EXPECT_NE(std::filesystem::last_write_time(scan_ / "plan.json"), time);
  EXPECT_EQ(std::filesystem::last_write_time(scan_ / "fragments/0000.flags"), fragment);
}

// Intrinsics of the options are ignored after the calibration of the camera.
TEST_F(PlanScanTest, UsesTheCalibratedCameraForAllFragments) {
  options_.run.sequence.intrinsics = {30, 30, 15, 11};
  PlanScan(options_);
  EXPECT_EQ(ReadScanPlan(scan_.path()).recordings[0].intrinsics, options_.run.sequence.intrinsics);
  EXPECT_THAT(ReadBytes(scan_ / "found_camera_0.flags"),
              AllOf(ContainsRegex("--intrinsics=\n"), Names("/camera/0/camera.yaml")));
  scan_.Write("camera/0/camera.yaml", SmallCameraYaml());
  const SequenceOptions found = ReadScanPlan(scan_.path()).recordings[0];
  EXPECT_FALSE(found.intrinsics.has_value());
  EXPECT_EQ(found.camera, scan_ / "camera/0/camera.yaml");
  options_.camera_frames = 0;
  PlanScan(options_);
  EXPECT_TRUE(ReadScanPlan(scan_.path()).recordings[0].camera.empty());
}

TEST_F(PlanScanTest, RejectsAMalformedPlan) {
  scan_.Write("plan.json", R"({"sequence": {}})");
  EXPECT_THAT([&] { ReadScanPlan(scan_.path()); },
              ThrowsNaming<InputError>("plan.json", "surfit_scan", "--step=plan"));
}

}  // namespace
}  // namespace surfit::testing
