// surfit_doctor on a simulated recording, and on copies with one fault each.
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

  // Names of the detected faults. Expects a consistent exit code.
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

  // Changes the images of a folder in the order of their names.
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
  // Changes the rows of a list of images.
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

TEST_F(DoctorTool, FindsNoFaultInAGoodRecording) {
  EXPECT_THAT(Faults(Room(), {}), IsEmpty());
  EXPECT_THAT(result_.out, Names(kFrames));
}

TEST_F(DoctorTool, DetectsAWrongDepthScale) {
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=1000"}), Contains("median_depth"));
  EXPECT_THAT(result_.out, Names(5000));
  // With this scale the depth is plausible (1 m), but its quantisation does not match the sensor.
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=10000"}),
              ElementsAre("inverse_depth_step"));
  EXPECT_THAT(result_.out, Names("--depth_scale=5000"));
}

TEST_F(DoctorTool, DetectsDepthThatIsCloseFarOrMissing) {
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=22000"}), Contains("too_close"));
  EXPECT_THAT(Faults(Room(), {"--notrack", "--depth_scale=2300"}), Contains("too_far"));
  const std::string copy = CopyOfRoom();
  Change(copy + "/depth", [](int, cv::Mat* depth) { depth->rowRange(60, 240) = 0; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("valid_depth"));
}

TEST_F(DoctorTool, DetectsShiftedColor) {
  // The full resolution has enough edges.
  const std::string room = SlamTool::Simulate("large", {"--frames=6", "--downsample=1"});
  EXPECT_THAT(FaultsOfImages(room), IsEmpty());
  Change(room + "/rgb", [](int, cv::Mat* color) {
    const cv::Mat moved = color->clone();
    moved.colRange(0, 616).copyTo(color->colRange(24, 640));
  });
  EXPECT_THAT(FaultsOfImages(room), ElementsAre("color_offset"));
  EXPECT_THAT(result_.out, ContainsRegex("(9[0-9]|100) %"));
  EXPECT_THAT(result_.out, ContainsRegex(" (20|24|28) px"));
  std::filesystem::remove(room + "/camera.yaml");
  EXPECT_THAT(FaultsOfImages(room), Contains("camera_guessed"));
}

// Both programs accept registered colour, and report the same colour after a shift.
TEST_F(DoctorTool, AgreesWithSlamAboutTheRegistrationOfColor) {
  const std::string room =
      SlamTool::Simulate("registered", {"--frames=10", "--downsample=1", "--sensor=ideal"});
  for (const bool shifted : {false, true}) {
    if (shifted) {
      Change(room + "/rgb", [](int, cv::Mat* color) {
        const cv::Mat moved = color->clone();
        moved.colRange(0, 560).copyTo(color->colRange(80, 640));
      });
    }
    const bool has_fault = ::testing::Value(FaultsOfImages(room), Contains("color_offset"));
    const ProgramResult run = Slam(room, Output(shifted ? "shifted" : "registered"),
                                   {"--nofinal_map", "--norefine", "--nocalibrate"});
    EXPECT_EQ(has_fault, shifted) << result_.out;
    EXPECT_EQ(run.err.find("edges of colour do not lie") != run.err.npos, shifted) << run.err;
  }
}

TEST_F(DoctorTool, DetectsDelayedColor) {
  const std::string early =
      SlamTool::Simulate("early", {"--frames=150", "--sensor_settings=color_latency_s=0.03"});
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

TEST_F(DoctorTool, DetectsLateStampsByTheGroundTruth) {
  const std::string late =
      Simulate("late", {"--sensor_settings=latency_s=0.05", "--step_m=0.01,0.03"});
  EXPECT_THAT(Faults(late, {}), ElementsAre("stamps_late"));
  EXPECT_THAT(result_.out, ContainsRegex("latency_s: 0\\.0(49|5)"));
}

TEST_F(DoctorTool, DetectsUnderOverAndChangingExposure) {
  const std::string copy = CopyOfRoom();
  Change(copy + "/rgb", [](int i, cv::Mat* color) { *color *= i % 5 == 0 ? 0.8 : 1.; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("exposure_changes"));
  Change(copy + "/rgb", [](int, cv::Mat* color) { *color *= 4; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("saturated"));
  Change(copy + "/rgb", [](int, cv::Mat* color) { *color *= 0.1; });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("brightness"));
}

TEST_F(DoctorTool, DetectsBlur) {
  const std::string copy = CopyOfRoom();
  Change(copy + "/rgb", [](int i, cv::Mat* color) {
    if (i % 3 == 0) cv::blur(*color, *color, {9, 1});  // motion blur
  });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("blurred"));
}

TEST_F(DoctorTool, DetectsMissingDuplicateAndUnorderedFrames) {
  const std::string list = "/associations.txt";
  std::string copy = CopyOfRoom();
  ChangeRows(copy + list, [](auto* rows) { rows->erase(rows->begin() + 9, rows->begin() + 15); });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("missing_frames"));
  EXPECT_THAT(result_.out, Names(6));

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

// The clock of the second take starts 20 s before the clock of the first take.
TEST_F(DoctorTool, DetectsASecondTakeWithEarlierTimestamps) {
  const std::string copy = CopyOfRoom();
  std::filesystem::remove(copy + "/associations.txt");
  std::filesystem::remove(copy + "/groundtruth.txt");
  for (const char* list : {"/depth.txt", "/rgb.txt"}) {
    ChangeRows(copy + list, [](auto* rows) {
      for (std::size_t i = 0; i < rows->size(); ++i) {
        std::string& row = rows->at(i);
        const double stamp_s = std::stod(row) + (i < rows->size() / 2 ? 100 : 80);
        row = std::to_string(stamp_s) + row.substr(row.find(' '));
      }
    });
  }
  EXPECT_THAT(FaultsOfImages(copy), Contains("stamps_not_ascending"));
  EXPECT_THAT(result_.err, HasSubstr("timestamps go back 1 times, first at frame 18"));
}

TEST_F(DoctorTool, DetectsUnpairedImages) {
  const std::string copy = CopyOfRoom();
  std::filesystem::remove(copy + "/associations.txt");
  EXPECT_THAT(FaultsOfImages(copy), IsEmpty());
  ChangeRows(copy + "/rgb.txt", [](auto* rows) { rows->resize(rows->size() - 9); });
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("unpaired_images"));
}

// Images without a partner outside the checked part are not reported as missing frames.
TEST_F(DoctorTool, DetectsUnpairedImagesOfTheWholeRecording) {
  const std::string copy = CopyOfRoom();
  std::filesystem::remove(copy + "/associations.txt");
  ChangeRows(copy + "/rgb.txt", [](auto* rows) { rows->resize(rows->size() - 3); });
  EXPECT_THAT(FaultsOfImages(copy), IsEmpty());
  EXPECT_THAT(Faults(copy, {"--notrack", "--last=5"}), IsEmpty());
}

TEST_F(DoctorTool, DetectsUnreadableAndSmallImages) {
  const std::string copy = CopyOfRoom();
  std::ofstream(copy + "/depth/" +
                std::filesystem::directory_iterator(copy + "/depth")->path().filename().string())
      << "no image";
  EXPECT_THAT(FaultsOfImages(copy), ElementsAre("unreadable_frames"));
  EXPECT_THAT(result_.out, Names(copy + "/depth/"));
  const std::string small = SlamTool::Simulate("small", {});
  EXPECT_THAT(FaultsOfImages(small), ElementsAre("depth_width"));
}

// Also in portrait orientation.
TEST_F(DoctorTool, AcceptsTheDepthOfPhones) {
  const std::vector<std::string> lidar = {"--frames=6", "--downsample=1", "--sensor=lidar"};
  std::vector<std::string> flags = lidar;
  flags.insert(flags.end(), {"--size=256x192"});
  EXPECT_THAT(FaultsOfImages(SlamTool::Simulate("phone", flags)), Not(Contains("depth_width")));
  flags = lidar;
  flags.insert(flags.end(), {"--size=192x256"});
  EXPECT_THAT(FaultsOfImages(SlamTool::Simulate("portrait", flags)), Not(Contains("depth_width")));
}

TEST_F(DoctorTool, DetectsAWrongCamera) {
  // The focal length of the sensor is 131.25 px.
  const std::string walk = SlamTool::Simulate("walk", {"--frames=150"});
  EXPECT_THAT(Faults(walk, {}), ElementsAre("depth_width"));
  EXPECT_THAT(Faults(walk, {"--intrinsics=78,78,79.9,59.9"}), Contains("focal_error"));
}

TEST_F(DoctorTool, DetectsWrongSignOfGyroscope) {
  const std::string sequence = SlamTool::Simulate(
      "inertial",
      {"--imu", "--sensor_settings=camera_yaml_imu=true", "--frames=150", "--downsample=2"});
  EXPECT_THAT(Faults(sequence, {}), IsEmpty());
  std::vector<std::string> rows = Lines(sequence + "/imu.csv");
  std::ofstream file(sequence + "/imu.csv");
  for (const std::string& row : rows) {
    if (row[0] == '#') {
      file << row << "\n";
      continue;
    }
    const auto first = row.find(','), second = row.find(',', first + 1);
    file << row.substr(0, first + 1) << -std::stod(row.substr(first + 1)) << row.substr(second)
         << "\n";
  }
  file.close();
  EXPECT_THAT(Faults(sequence, {}), ElementsAre("imu"));
}

TEST_F(DoctorTool, DetectsLostFrames) {
  const std::string copy = CopyOfRoom();
  Change(copy + "/depth", [](int i, cv::Mat* depth) {
    if (i % 4 == 3) *depth = 0;
  });
  EXPECT_THAT(Faults(copy, {}), Contains("lost_frames"));
}

TEST_F(DoctorTool, RejectsOtherFoldersAndCameras) {
  ExpectRefused(RunProgram("surfit_doctor", {"--sequence=" + own_.path()}), own_.path());
  ExpectRefused(RunProgram("surfit_doctor", {"--sequence=any", "--format=openni2"}), "openni2");
}

}  // namespace
}  // namespace surfit::testing
