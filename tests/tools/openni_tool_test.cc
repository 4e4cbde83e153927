// surfit_slam and surfit_record with OpenNI2 recordings and a virtual OpenNI2 camera.
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "testing/matchers.h"
#include "testing/openni/virtual_camera.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class OpenNiTool : public SlamTool {
 protected:
  // Images of the room as a film for the virtual camera.
  static std::vector<FilmFrame> Film() {
    std::vector<FilmFrame> film;
    for (const std::string& line : Lines(Room() + "/associations.txt")) {
      std::string stamp, color, depth;
      std::istringstream(line) >> stamp >> color >> stamp >> depth;
      const cv::Mat bgr = cv::imread(Room() + "/" + color);
      const cv::Mat counts = cv::imread(Room() + "/" + depth, cv::IMREAD_UNCHANGED);
      FilmFrame frame;
      frame.color = Image<Rgb8>(bgr.cols, bgr.rows);
      frame.depth = Image<std::uint16_t>(counts.cols, counts.rows);
      for (std::size_t i = 0; i < frame.depth.size(); ++i) {
        const cv::Vec3b pixel = bgr.at<cv::Vec3b>(static_cast<int>(i));
        frame.color[i] = {pixel[2], pixel[1], pixel[0]};
        frame.depth[i] = counts.at<std::uint16_t>(static_cast<int>(i));
      }
      film.push_back(
          FilmFrameOf(static_cast<int>(film.size()), std::move(frame.depth), frame.color));
    }
    return film;
  }

  // A copy of the room with the timestamps of an OpenNI2 recording.
  std::string CopyWithStampsOfOni() const {
    const std::string folder = CopyOfRoom();
    fs::remove(folder + "/groundtruth.txt");
    std::ofstream pairs(folder + "/associations.txt"), colors(folder + "/rgb.txt"),
        depths(folder + "/depth.txt");
    const std::vector<std::string> rows = Lines(Room() + "/associations.txt");
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::string stamp, color, depth;
      std::istringstream(rows[i]) >> stamp >> color >> stamp >> depth;
      char text[32];
      std::snprintf(text, sizeof(text), "0.%06zu", 33333 * i);
      pairs << text << " " << color << " " << text << " " << depth << "\n";
      colors << text << " " << color << "\n";
      depths << text << " " << depth << "\n";
    }
    return folder;
  }
  // OpenNI2 recording of the same frames, with the camera file of the folder.
  std::string Recorded() const {
    const std::string oni = own_ / "room.oni";
    const VirtualCamera camera({}, Film());
    RecordOni(oni);
    fs::copy(Room() + "/camera.yaml", oni + ".yaml");
    return oni;
  }

  // Programs load the library of the virtual camera.
  OpenNiTool() {
    const char* const path = std::getenv("LD_LIBRARY_PATH");
    const std::string folder = fs::path(VirtualCamera::library()).parent_path();
    setenv("LD_LIBRARY_PATH", path == nullptr ? folder.c_str() : (folder + ":" + path).c_str(), 1);
  }
};

TEST_F(OpenNiTool, RecordingHasTheResultOfTheFolder) {
  const std::string folder = CopyWithStampsOfOni(), oni = Recorded();
  Succeeded(Slam(folder, Output("folder")));
  Succeeded(Slam(oni, Output("oni")));
  const std::string copy = own_.path() + "/recorded";
  Succeeded(RunProgram("surfit_record", {"--sequence=" + oni, "--output=" + copy}));
  Succeeded(Slam(copy, Output("copy")));
  const nlohmann::json expected = Summary(Output("folder"));
  EXPECT_EQ(expected["frames_tracked"], kFrames);
  for (const char* name : {"oni", "copy"}) {
    EXPECT_EQ(Summary(Output(name))["digest"], expected["digest"]) << name;
    EXPECT_EQ(ReadBytes(Output(name) + "/trajectory.txt"),
              ReadBytes(Output("folder") + "/trajectory.txt"));
  }
}

// Each recording is written by a third-party program. Missing programs are reported.
TEST_F(OpenNiTool, EveryRecordingFormatHasTheResultOfTheFolder) {
  const std::string folder = CopyWithStampsOfOni(), bags = own_.path() + "/bags";
  const ProgramResult written =
      RunShell("'" SURFIT_TEST_PYTHON "' '" SURFIT_TEST_BAGS_DIR "/write_bags.py' '" + folder +
               "' '" + bags + "'");
  Succeeded(Slam(folder, Output("folder")));
  const nlohmann::json expected = Summary(Output("folder"));
  std::string missing;
  for (const std::string& path :
       {Recorded(), bags + "/room.bag", bags + "/room.db3", bags + "/room.mcap"}) {
    if (!fs::exists(path)) {
      missing += " " + fs::path(path).filename().string();
      continue;
    }
    const std::string output = Output(fs::path(path).extension());
    Succeeded(Slam(path, output, {"--depth_scale=5000"}));
    EXPECT_EQ(Summary(output)["digest"], expected["digest"]) << path;
    EXPECT_EQ(ReadBytes(output + "/trajectory.txt"),
              ReadBytes(Output("folder") + "/trajectory.txt"));
  }
  if (!missing.empty()) {
    GTEST_SKIP() << "nothing writes" << missing << ": " << written.out << written.err;
  }
}

TEST_F(OpenNiTool, CameraKeepsItsMapAfterReconnection) {
  // Forward and backward: the last frames before the disconnection may be late and lost.
  std::vector<FilmFrame> film = Film();
  for (int i = kFrames - 2; i >= 0; --i)
    film.push_back(FilmFrameOf(2 * kFrames - 2 - i, film[i].depth, film[i].color));
  CameraScript script;
  script.period_us = 60000;
  script.unplugged_at = 12;
  script.away_ms = 300;
  const VirtualCamera camera(script, film);
  const ProgramResult result =
      Succeeded(Slam("any", Output(),
                     {"--format=openni2", "--device=160x120@30", "--last=20",
                      "--camera=" + Room() + "/camera.yaml"}));
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["pauses"], 1);
  EXPECT_GE(summary["paused_s"], 0.3);
  EXPECT_EQ(summary["frames_total"].get<int>() + summary["frames_dropped"].get<int>(), 21);
  EXPECT_EQ(summary["frames_lost"], 0);
  EXPECT_THAT(result.err, HasWarning("Surfit", "Virtual"));
  EXPECT_GE(LinesWith("Surfit Virtual", result.err).size(), 2u);  // disconnected and reconnected
}

TEST_F(OpenNiTool, RecordsACamera) {
  CameraScript script;
  script.period_us = 20000;
  const VirtualCamera camera(script, Film());
  const std::string copy = own_.path() + "/recorded";
  const ProgramResult result = Succeeded(
      RunProgram("surfit_record", {"--sequence=test://1", "--output=" + copy, "--format=openni2",
                                   "--device=160x120@30", "--last=15"}));
  EXPECT_THAT(result.out, Names(16));
  Succeeded(Slam(copy, Output(), {"--camera=" + Room() + "/camera.yaml"}));
  EXPECT_EQ(Summary(Output())["frames_tracked"], 16);
}

TEST_F(OpenNiTool, RejectsMissingLibrary) {
  const TempFolder folder;
  folder.Write("libOpenNI2.so.0", "no library");
  setenv("LD_LIBRARY_PATH", folder.path().c_str(), 1);
  ExpectRefused(Slam("any", Output(), {"--format=openni2"}), "libOpenNI2.so.0", "libopenni2-0");
}

}  // namespace
}  // namespace surfit::testing
