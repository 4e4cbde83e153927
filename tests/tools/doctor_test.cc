// What surfit_doctor says of a simulated recording, and of the same with one fault.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

using ::testing::Contains;
using ::testing::ContainsRegex;

class DoctorTool : public SlamTool {
 protected:
  static constexpr int kFrames = 36;

  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    Simulate("room", {});
  }
  static std::string Simulate(const std::string& name, std::vector<std::string> flags) {
    flags.insert(flags.end(), {Concat("--frames=", kFrames), "--downsample=2"});
    return SlamTool::Simulate(name, flags);
  }

  // The names of the faults that are found; the exit code must agree.
  std::vector<std::string> Faults(const std::string& sequence, std::vector<std::string> flags) {
    const std::string summary = own_ / "summary.json";
    flags.insert(flags.end(), {"--sequence=" + sequence, "--summary=" + summary});
    result_ = RunProgram("surfit_doctor", flags);
    const auto json = nlohmann::json::parse(ReadBytes(summary));
    std::vector<std::string> faults;
    for (const auto& check : json["checks"]) {
      if (check["is_sound"]) continue;
      faults.push_back(check["name"]);
      EXPECT_THAT(result_.out, HasSubstr(check["fault"].get<std::string>()));
      EXPECT_THAT(result_.out, HasSubstr(check["advice"].get<std::string>()));
    }
    EXPECT_EQ(result_.exit_code, faults.empty() ? 0 : 3) << result_.err;
    EXPECT_EQ(json["is_sound"], faults.empty());
    return faults;
  }
  std::vector<std::string> FaultsOfImages(const std::string& sequence) {
    return Faults(sequence, {"--notrack"});
  }

  // Changes the files of one of the copy's folders, in their order.
  static void Change(const std::string& folder, const std::function<void(int, cv::Mat*)>& change) {
    std::vector<std::string> paths;
    for (const auto& file : std::filesystem::directory_iterator(folder))
      paths.push_back(file.path());
    std::sort(paths.begin(), paths.end());
    for (std::size_t i = 0; i < paths.size(); ++i) {
      cv::Mat image = cv::imread(paths[i], cv::IMREAD_UNCHANGED);
      change(static_cast<int>(i), &image);
      cv::imwrite(paths[i], image);
    }
  }
  // Rows of one of the copy's lists, and these again.
  static void ChangeRows(const std::string& path,
                         const std::function<void(std::vector<std::string>*)>& change) {
    std::vector<std::string> rows = Lines(path);
    while (!rows.empty() && rows[0][0] == '#') rows.erase(rows.begin());
    change(&rows);
    std::ofstream file(path);
    for (const std::string& row : rows) file << row << "\n";
  }

  ProgramResult result_;
};

TEST_F(DoctorTool, FindsNothingWrongWithASoundRecording) {
  EXPECT_THAT(Faults(Room(), {}), IsEmpty());
  EXPECT_THAT(result_.out, HasSubstr(Concat("nothing is wrong with ", kFrames, " frames")));
}

TEST_F(DoctorTool, TellsAWrongScale) {
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=1000"}), Contains("median_depth"));
  EXPECT_THAT(result_.out, HasSubstr("the scale is more likely 5000"));
  // By this one depth is a plausible metre, but goes in steps of another sensor.
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=10000"}),
              ElementsAre("inverse_depth_step"));
  EXPECT_THAT(result_.out, HasSubstr("give --depth_scale=5000"));
}

TEST_F(DoctorTool, TellsDepthThatIsNearFarOrMissing) {
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=22000"}), Contains("too_close"));
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=2300"}), Contains("too_far"));
  const std::string copy = CopyOfRoom();
  Change(copy + "/depth", [](int, cv::Mat* depth) { depth->rowRange(60, 240) = 0; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("valid_depth"));
}

TEST_F(DoctorTool, TellsColorThatLiesElsewhere) {
  // At the whole resolution, where there are edges enough.
  const std::string room = SlamTool::Simulate("large", {"--frames=6", "--downsample=1"});
  EXPECT_THAT(FaultsOfImages(room), IsEmpty());
  Change(room + "/rgb", [](int, cv::Mat* color) {
    const cv::Mat moved = color->clone();
    moved.colRange(0, 616).copyTo(color->colRange(24, 640));
  });
  EXPECT_THAT(FaultsOfImages(room), ElementsAre("color_offset"));
  EXPECT_THAT(result_.out, ContainsRegex("9[0-9] % as large|100 % as large"));
  EXPECT_THAT(result_.out, ContainsRegex("large, (20|24|28) px to the right"));
  std::filesystem::remove(room + "/camera.yaml");
  EXPECT_THAT(FaultsOfImages(room), Contains("camera_guessed"));
}

TEST_F(DoctorTool, TellsColorOfAnotherMoment) {
  const std::string early = SlamTool::Simulate("early", {"--frames=150", "--color_latency_s=0.03"});
  EXPECT_THAT(Faults(early, {}), ElementsAre("depth_width", "color_latency"));
  const std::string copy = CopyOfRoom();
  ChangeRows(copy + "/associations.txt", [](auto* rows) {
    for (std::string& row : *rows) {
      const auto space = row.find(' ');
      row =
          Concat(std::setprecision(12), std::stod(row.substr(0, space)) + 0.018, row.substr(space));
    }
  });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("color_stamp_after_depth"));
}

TEST_F(DoctorTool, TellsStampsThatAreLateByTheTruth) {
  const std::string late = Simulate("late", {"--latency_s=0.05", "--max_step_m=0.03"});
  EXPECT_THAT(Faults(late, {}), ElementsAre("stamps_late"));
  EXPECT_THAT(result_.out, ContainsRegex("give depth's delay: --latency_s=0\\.0(49|5)"));
}

TEST_F(DoctorTool, TellsLightThatIsTooLittleTooMuchOrChanges) {
  const std::string copy = CopyOfRoom();
  Change(copy + "/rgb", [](int i, cv::Mat* color) { *color *= i % 5 == 0 ? 0.8 : 1.; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("exposure_changes"));
  Change(copy + "/rgb", [](int, cv::Mat* color) { *color *= 4; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("saturated"));
  Change(copy + "/rgb", [](int, cv::Mat* color) { *color *= 0.1; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("brightness"));
}

TEST_F(DoctorTool, TellsBlur) {
  const std::string copy = CopyOfRoom();
  Change(copy + "/rgb", [](int i, cv::Mat* color) {
    if (i % 3 == 0) cv::blur(*color, *color, {9, 1});  // as if the camera turned about
  });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("blurred"));
}

TEST_F(DoctorTool, TellsFramesThatAreMissingRepeatedOrOutOfOrder) {
  const std::string list = "/associations.txt";
  std::string copy = CopyOfRoom();
  ChangeRows(copy + list, [](auto* rows) { rows->erase(rows->begin() + 9, rows->begin() + 15); });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("missing_frames"));
  EXPECT_THAT(result_.out, HasSubstr("6 frames are missing"));

  std::filesystem::remove_all(copy);
  copy = CopyOfRoom();
  Change(copy + "/depth", [last = cv::Mat()](int i, cv::Mat* depth) mutable {
    if (i % 9 == 1) last.copyTo(*depth);
    last = depth->clone();
  });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("repeated_depth"));
  Change(copy + "/rgb", [last = cv::Mat()](int i, cv::Mat* color) mutable {
    if (i % 9 == 1) last.copyTo(*color);
    last = color->clone();
  });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("repeated_depth", "repeated_color"));

  std::filesystem::remove_all(copy);
  copy = CopyOfRoom();
  ChangeRows(copy + list, [](auto* rows) {
    rows->at(7) = rows->at(6).substr(0, rows->at(6).find(' ')) + " " +
                  rows->at(7).substr(rows->at(7).find(' ') + 1);
    const auto depth_at = [](const std::string& row) {
      return row.find(' ', row.find(' ') + 1) + 1;
    };
    std::string& row = rows->at(7);
    const std::string stamp = row.substr(0, row.find(' '));
    row.replace(depth_at(row), row.find(' ', depth_at(row)) - depth_at(row), stamp);
  });
  EXPECT_THAT(FaultsOfImages(copy), Contains("stamps_not_ascending"));
}

TEST_F(DoctorTool, TellsImagesWithoutPartner) {
  const std::string copy = CopyOfRoom();
  std::filesystem::remove(copy + "/associations.txt");
  EXPECT_THAT(FaultsOfImages(copy), IsEmpty());
  ChangeRows(copy + "/rgb.txt", [](auto* rows) { rows->resize(rows->size() - 9); });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("unpaired_images"));
}

// What the whole recording leaves out is not held against the part that is looked at.
TEST_F(DoctorTool, TellsUnpairedImagesOfTheWholeRecording) {
  const std::string copy = CopyOfRoom();
  std::filesystem::remove(copy + "/associations.txt");
  ChangeRows(copy + "/rgb.txt", [](auto* rows) { rows->resize(rows->size() - 3); });
  EXPECT_THAT(FaultsOfImages(copy), IsEmpty());
  EXPECT_THAT(Faults(copy, {"--notrack", "--last=5"}), IsEmpty());
}

TEST_F(DoctorTool, TellsWhatCannotBeReadAndImagesThatAreSmall) {
  const std::string copy = CopyOfRoom();
  std::ofstream(copy + "/depth/" +
                std::filesystem::directory_iterator(copy + "/depth")->path().filename().string())
      << "no image";
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("unreadable_frames"));
  EXPECT_THAT(result_.out, HasSubstr(copy + "/depth/"));
  const std::string small = SlamTool::Simulate("small", {});
  EXPECT_THAT(FaultsOfImages(small), ElementsAre("depth_width"));
}

TEST_F(DoctorTool, TellsACameraThatIsHardlyTheSensor) {
  // The sensor's focal lengths are 131.25 px.
  const std::string walk = SlamTool::Simulate("walk", {"--frames=150"});
  EXPECT_THAT(Faults(walk, {}), ElementsAre("depth_width"));
  EXPECT_THAT(Faults(walk, {"--intrinsics=78,78,79.9,59.9"}), Contains("focal_error"));
}

TEST_F(DoctorTool, TellsThatTrackingLosesFrames) {
  const std::string copy = CopyOfRoom();
  Change(copy + "/depth", [](int i, cv::Mat* depth) {
    if (i % 4 == 3) *depth = 0;
  });
  EXPECT_THAT(Faults(copy, {}), Contains("lost_frames"));
}

TEST_F(DoctorTool, RefusesWhatIsNoRecording) {
  ExpectRefused(RunProgram("surfit_doctor", {"--sequence=" + own_.path()}), own_.path());
  ExpectRefused(RunProgram("surfit_doctor", {"--sequence=any", "--format=openni2"}),
                "only a live run");
}

}  // namespace
}  // namespace surfit::testing
