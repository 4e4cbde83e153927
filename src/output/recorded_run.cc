#include "output/recorded_run.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "output/output_files.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

void ReadPoses(const std::string& path, RecordedRun* run) {
  constexpr double kTolerance = 0.01;
  const Json json = ReadJson(path);
  try {
    for (const Json& row : json.at("poses")) {
      const auto number = [&](int i) { return row.at(i).get<double>(); };
      const Eigen::Quaterniond rotation(number(8), number(5), number(6), number(7));
      ThrowIf(!(std::abs(rotation.norm() - 1) <= kTolerance), path, ": pose of frame ",
              row.at(0).get<int>(), ": the norm of the quaternion is ", rotation.norm(),
              ", must be 1");
      const Rigid3d pose(rotation.normalized(), {number(2), number(3), number(4)});
      run->trajectory.push_back({number(1), pose});
      run->world_from_camera[row.at(0).get<int>()] = pose;
    }
    run->found.color_latency_s = json.value("color_latency_s", 0.);
    const Json& found = json.at("calibration");
    if (!found.is_null()) {
      DepthCalibration& calibration = run->found.calibration.emplace();
      calibration.camera = CameraFromJson(json.at("camera"));
      found.at("inverse_depth_field").get_to(calibration.field.coefficients);
      calibration.readout_s = found.at("readout_s");
    }
  } catch (const Json::exception& error) {
    throw InputError(Concat(path, ": incomplete: ", error.what()));
  }
}

}  // namespace

RecordedRun ReadRecordedRun(const std::string& folder) {
  RecordedRun run;
  ReadPoses(folder + "/poses.json", &run);
  const Json summary = ReadJson(folder + "/summary.json");
  for (const Json& frame : summary.value("held_out_frames", Json::array())) {
    if (frame.is_number_integer()) run.held_out.insert(frame.get<int>());
  }
  return run;
}

void RequireCameraOfFrames(const RecordedRun& run, const std::string& folder,
                           const PinholeCamera& frames) {
  if (!run.found.calibration) return;
  const PinholeCamera& found = run.found.calibration->camera;
  if (found.width == frames.width && found.height == frames.height) return;
  throw InputError(Concat(folder, "/poses.json: the camera has ", found.width, " x ", found.height,
                          " pixels, must have ", frames.width, " x ", frames.height,
                          " like the frames"));
}

std::string ViewPictureName(int rank) {
  std::array<char, 40> name;
  std::snprintf(name.data(), name.size(), "view_pictures/%02d.png", rank);
  return name.data();
}

std::vector<std::string> ViewFileNames() {
  std::vector<std::string> names = {"views.json", "views.csv"};
  for (int i = 0; i < kMaxViewPictures; ++i) names.push_back(ViewPictureName(i));
  return names;
}

}  // namespace surfit
