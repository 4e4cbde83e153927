#include "run/results/tracking_dump.h"

#include <algorithm>
#include <vector>

#include "io/files/output_folder.h"
#include "output/output_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

Json ToJson(const DepthSensor& sensor) {
  Json json = CameraToJson(sensor.camera);
  json["inverse_depth_sigma"] = sensor.noise.inverse_depth_sigma;
  return json;
}

DepthSensor SensorFromJson(const Json& json) {
  DepthSensor sensor = {CameraFromJson(json), {json.at("inverse_depth_sigma")}};
  sensor.Validate();
  return sensor;
}

Json PoseToJson(const Rigid3d& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Vector4d& q = pose.rotation.coeffs();
  return {{"translation_m", {t.x(), t.y(), t.z()}}, {"rotation_xyzw", {q[0], q[1], q[2], q[3]}}};
}

Rigid3d PoseFromJson(const Json& json) {
  const Json &t = json.at("translation_m"), &q = json.at("rotation_xyzw");
  return {Eigen::Quaterniond(q.at(3), q.at(0), q.at(1), q.at(2)),
          Eigen::Vector3d(t.at(0), t.at(1), t.at(2))};
}

std::vector<Eigen::Vector3f> AllPixels(const VectorImage& image) {
  std::vector<Eigen::Vector3f> values;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) values.push_back(image(u, v));
  }
  return values;
}

VectorImage AsImage(const std::vector<Eigen::Vector3f>& values, const PinholeCamera& camera) {
  VectorImage image(camera.width, camera.height);
  std::size_t i = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) image.Set(u, v, values[i++]);
  }
  return image;
}

void WriteView(const FrameLevel& level, const Image<Rgb8>& color, const std::string& path) {
  WritePly({AllPixels(level.vertex), AllPixels(level.normal), {color.begin(), color.end()}}, path);
}

FramePyramid ReadView(const DepthSensor& sensor, const PreprocessOptions& options,
                      const std::string& path) {
  const PinholeCamera& camera = sensor.camera;
  const PointCloud cloud = ReadPly(path);
  const auto pixels = static_cast<std::size_t>(camera.width) * camera.height;
  if (cloud.points.size() != pixels || cloud.normals.size() != pixels) {
    throw InputError(Concat(path, ": has ", cloud.points.size(), " points and ",
                            cloud.normals.size(), " normals, must have ", pixels, " of each"));
  }
  FramePyramid pyramid = BuildPyramid(
      {camera, sensor.noise, AsImage(cloud.points, camera), AsImage(cloud.normals, camera), {}},
      options);
  if (!cloud.colors.empty()) {
    Image<Rgb8> color(camera.width, camera.height);
    std::copy(cloud.colors.begin(), cloud.colors.end(), color.begin());
    AddIntensity(color, &pyramid);
  }
  return pyramid;
}

}  // namespace

void WriteTrackingDump(const LostFrame& lost, const SlamOptions& options,
                       const std::string& folder) {
  const OutputFolder owned(folder, {"frame.json", "source.ply", "target.ply"});
  const FrameLevel &source = lost.source.levels.front(), &target = lost.target.levels.front();
  WriteView(source, lost.source_color, folder + "/source.ply");
  WriteView(target, lost.target_color, folder + "/target.ply");
  Json json;
  json["frame"] = lost.index;
  json["termination"] = ToString(lost.icp.termination);
  json["source_sensor"] = ToJson(source.sensor());
  json["target_sensor"] = ToJson(target.sensor());
  json["target_from_source_initial"] = PoseToJson(lost.target_from_source_initial);
  json["preprocess"] = OptionsToJson(options.preprocess);
  json["icp"] = OptionsToJson(lost.icp_options);
  WriteJson(json, folder + "/frame.json");
}

TrackingDump ReadTrackingDump(const std::string& folder) {
  const std::string path = folder + "/frame.json";
  try {
    const Json json = ReadJson(path);
    const auto preprocess = OptionsFromJson<PreprocessOptions>(json.at("preprocess"));
    Validate(preprocess);
    TrackingDump dump;
    dump.frame = json.at("frame");
    dump.termination = json.at("termination");
    dump.target_from_source_initial = PoseFromJson(json.at("target_from_source_initial"));
    dump.icp = OptionsFromJson<IcpOptions>(json.at("icp"));
    Validate(dump.icp);
    dump.source =
        ReadView(SensorFromJson(json.at("source_sensor")), preprocess, folder + "/source.ply");
    dump.target =
        ReadView(SensorFromJson(json.at("target_sensor")), preprocess, folder + "/target.ply");
    return dump;
  } catch (const Json::exception& error) {
    throw InputError(path + ": " + error.what());
  }
}

}  // namespace surfit
