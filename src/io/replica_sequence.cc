#include "io/replica_sequence.h"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "core/read_file.h"
#include "io/folder.h"
#include "io/matrix_text.h"
#include "io/sequence_files.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_presets.h"

namespace surfit {
namespace {

RgbdCamera ReadCamParams(const std::string& path) {
  RgbdCamera camera;
  try {
    const auto json = nlohmann::json::parse(ReadFile(path)).at("camera");
    camera.depth.width = json.at("w").get<int>();
    camera.depth.height = json.at("h").get<int>();
    camera.depth.fx = json.at("fx").get<double>();
    camera.depth.fy = json.at("fy").get<double>();
    camera.depth.cx = json.at("cx").get<double>();
    camera.depth.cy = json.at("cy").get<double>();
    camera.depth_units_per_metre = json.at("scale").get<double>();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(Concat(path, ": ", error.what()));
  }
  camera.Validate(path);
  return camera;
}

// A 4 x 4 matrix a line, row by row.
Rigid3d ParseLine(const TextRow& row) {
  if (row.columns.size() != 16)
    throw InputError(Concat(row.place, " has ", row.columns.size(), " columns, must have 16"));
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = ParseNumber(row.columns[i], row.place);
  return RigidFromMatrix(matrix, row.place);
}

}  // namespace

RgbdCamera ReplicaCamera(const std::string& folder) {
  for (const char* name : {"/cam_params.json", "/../cam_params.json"}) {
    if (IsFile(folder + name)) return ReadCamParams(folder + name);
  }
  return CameraPreset("replica");
}

SequenceFiles ListReplicaSequence(const std::string& folder, double frames_per_second) {
  std::set<long> numbers;
  for (const std::string& name : NamesIn(folder + "/results")) {
    const auto number = NumberInName(name);
    const bool is_image = name.compare(0, 5, "frame") == 0 || name.compare(0, 5, "depth") == 0;
    if (number && is_image) numbers.insert(*number);
  }
  SequenceFiles files;
  for (const long number : numbers) {
    std::array<char, 30> digits;
    std::snprintf(digits.data(), digits.size(), "%06ld", number);
    const std::string results = folder + "/results/";
    files.frames.push_back({static_cast<double>(number) / frames_per_second,
                            results + "depth" + digits.data() + ".png",
                            results + "frame" + digits.data() + ".jpg"});
  }
  double index = 0;
  for (const TextRow& row : ReadTextRows(folder + "/traj.txt"))
    files.ground_truth.push_back({index++ / frames_per_second, ParseLine(row)});
  return files;
}

}  // namespace surfit
