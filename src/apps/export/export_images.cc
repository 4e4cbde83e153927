#include "apps/export/export_images.h"

#include <cstddef>

#include "apps/export/color_calibration.h"
#include "apps/export/image_poses.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {
namespace {

// Pose of the depth camera `seconds` after the time of the image.
Rigid3d ExtrapolatedTo(const Trajectory& trajectory, const ColorImage& image, double seconds) {
  constexpr double kMaxGap_s = 0.1, kSameTime_s = 1e-9;
  if (seconds == 0) return image.world_from_depth;
  if (const auto pose =
          InterpolatePose(trajectory, image.stamp_s + seconds, kMaxGap_s, kSameTime_s)) {
    return *pose;
  }
  const Rigid3d motion(QuaternionExp<double>(seconds * image.motion.angular_velocity_rad_per_s),
                       seconds * image.motion.velocity_m_per_s);
  return image.world_from_depth * motion;
}

void ReportCamera(const ColorCalibration& found, double run_latency_s, ExportLog* log) {
  const PinholeCamera& lens = found.camera.lens;
  Json& json = log->json["color_camera"];
  json = CameraToJson(lens);
  json["distortion"] = lens.distortion;
  json["color_from_depth"] = ToJson(found.camera.color_from_depth);
  json["estimated"] = found.is_estimated;
  json["latency_s"] = run_latency_s + found.latency_s;
  json["change"] = std::vector<double>(found.change.begin(), found.change.end());
  json["sigmas"] = std::vector<double>(found.sigmas.begin(), found.sigmas.end());
  json["distance2"] = found.distance2;
  json["limit2"] = found.limit2;
  json["rms_log_brightness"] = {found.rms_before, found.rms_after};
  json["images"] = found.images;
  json["observations"] = found.observations;
  if (!found.is_estimated) {
    log->Say("colour camera as given", found.images == 0
                                           ? ": too few images or surfels to estimate it"
                                           : ", confirmed by the images");
    return;
  }
  log->Say("colour camera estimated from ", found.images, " images: fx ", lens.fx, ", fy ", lens.fy,
           ", cx ", lens.cx, ", cy ", lens.cy, " px; its pose changes by ",
           1000 * found.change.segment<3>(3).norm(), " mm and ",
           DegreesText(found.change.head<3>().norm()), ", its latency by ", 1000 * found.latency_s,
           " ms");
}

void ReportRegistration(const ImageRegistration& found, ExportLog* log) {
  log->json["registration"] = {{"registered", found.registered},
                               {"too_few_surfels", found.too_few_surfels},
                               {"contradicting", found.contradicting},
                               {"without_gain", found.without_gain},
                               {"median_change_m", found.median_change_m},
                               {"median_change_rad", found.median_change_rad},
                               {"rms_log_brightness", {found.rms_before, found.rms_after}}};
  log->Say(found.registered, " images registered to each other, median change ",
           std::round(1e4 * found.median_change_m) / 10, " mm and ",
           DegreesText(found.median_change_rad), "; ",
           found.too_few_surfels + found.contradicting + found.without_gain,
           " keep the tracked pose");
}

void ReportUnused(const UnusedFrames& unused, std::size_t used, bool writes_images,
                  std::size_t frames_with_pose, ExportLog* log) {
  log->json["images"] = {{writes_images ? "written" : "used", used},
                         {"not_chosen", unused.not_chosen},
                         {"without_color", unused.without_color},
                         {"unreadable", unused.unreadable},
                         {"repeated", unused.repeated},
                         {"without_pose_at_time", unused.without_pose_at_time}};
  log->Say(used, " images of ", frames_with_pose, " frames with poses; ", unused.not_chosen,
           " not chosen, ", unused.repeated, " repeat the previous image, ", unused.without_color,
           " without colour, ", unused.unreadable, " unreadable, ", unused.without_pose_at_time,
           " without a pose at the time of the image");
}

}  // namespace

std::vector<ColorImage> ExportImages::Sources() const {
  std::vector<ColorImage> sources;
  sources.reserve(posed.size());
  for (const PosedImage& image : posed) sources.push_back(image.source);
  return sources;
}

ExportImages PrepareImages(const ExportOptions& options, const RecordedRun& run,
                           const SurfelMap& map, int most, ExportLog* log) {
  const bool writes_images = options.to != "gaussians";
  const SequenceInfo info = OpenSequence(options.sequence)->info();
  RequireCameraOfFrames(run, options.run, info.pinhole);
  UnusedFrames unused;
  const std::vector<ColorImage> all = ListColorImages(
      options.sequence, run, [&](int i) { log->Progress("reading images, ", i); }, &unused);
  ThrowIf(all.empty(), options.run, ": no frame has both colour and a pose");
  ExportImages images;
  images.camera = images.given_camera = GivenColorCamera(info, run);
  double latency_s = 0;
  if (writes_images) {
    const ColorCalibration found =
        EstimateColorCamera(images.given_camera, info.sensor().prior, options.sequence, all, map,
                            [&](int i) { log->Progress("estimating the colour camera, ", i); });
    images.camera = found.camera;
    latency_s = found.latency_s;
    ReportCamera(found, run.found.color_latency_s, log);
  }
  const std::vector<ColorImage> chosen = ChooseImages(all, most);
  unused.not_chosen = static_cast<int>(all.size() - chosen.size());
  for (const ColorImage& image : chosen) {
    const Rigid3d world_from_depth = ExtrapolatedTo(run.trajectory, image, -latency_s);
    images.posed.push_back({image, world_from_depth * images.camera.color_from_depth.Inverse()});
    images.posed.back().source.stamp_s -= latency_s;
  }
  if (writes_images) {
    const ImageRegistration found = RegisterImages(
        images.camera, map,
        [&](const std::vector<ColorImage>& sources, const auto& call) {
          ReadColorImages(options.sequence, sources, call);
        },
        [&](int i) { log->Progress("registering images, ", i); }, &images.posed);
    ReportRegistration(found, log);
  }
  ReportUnused(unused, images.posed.size(), writes_images, run.trajectory.size(), log);
  return images;
}

}  // namespace surfit
