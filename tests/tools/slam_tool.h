#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "testing/run_program.h"
#include "testing/temp_folder.h"

namespace surfit::testing {

inline std::vector<std::string> Lines(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

inline int CountPoses(const std::string& path) {
  const auto lines = Lines(path);
  return static_cast<int>(std::count_if(lines.begin(), lines.end(), [](const std::string& line) {
    return !line.empty() && line[0] != '#';
  }));
}

// Runs surfit_slam on a simulated Kinect recording of a room at 160 x 120 pixels. All tests of a
// suite share the recording.
class SlamTool : public ::testing::Test {
 protected:
  static constexpr int kFrames = 24;

  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    Simulate("room", {});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string Simulate(const std::string& name, std::vector<std::string> flags) {
    const std::string path = folder_->path() + "/" + name;
    flags.insert(flags.begin(), {"--output=" + path, "--frames=" + std::to_string(kFrames),
                                 "--sensor=kinect", "--downsample=4"});
    Succeeded(RunProgram("surfit_simulate", flags));
    return path;
  }
  static std::string Room() { return folder_->path() + "/room"; }
  // A copy of the room that tests may modify.
  std::string CopyOfRoom() const {
    const std::string copy = own_.path() + "/copy";
    std::filesystem::copy(Room(), copy, std::filesystem::copy_options::recursive);
    return copy;
  }
  // The frames of the room, repeated so often that no run ends before it is interrupted.
  std::string EndlessRoom() const {
    const std::string copy = CopyOfRoom();
    const std::vector<std::string> rows = Lines(copy + "/associations.txt");
    std::ofstream file(copy + "/associations.txt");
    for (int i = 0; i < 10000; ++i) {
      std::istringstream row(rows[i % rows.size()]);
      std::string stamp, color, depth;
      row >> stamp >> color >> stamp >> depth;
      file << i << " " << color << " " << i << " " << depth << "\n";
    }
    return copy;
  }
  std::string Output(const std::string& name = "out") const { return own_.path() + "/" + name; }

  ProgramResult Slam(const std::string& sequence, const std::string& output,
                     std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"--sequence=" + sequence, "--output=" + output});
    if (!pictures_) flags.push_back("--nopictures");
    return RunProgram("surfit_slam", flags);
  }
  static nlohmann::json Summary(const std::string& output) {
    return nlohmann::json::parse(ReadBytes(output + "/summary.json"));
  }

  static inline TempFolder* folder_ = nullptr;
  TempFolder own_;
  bool pictures_ = false;
};

}  // namespace surfit::testing
