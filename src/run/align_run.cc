#include "surfit/run/align_run.h"

#include <vector>

#include "run/output_folder.h"
#include "run/posed_view.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/intensity.h"
#include "surfit/io/point_cloud.h"
#include "surfit/pictures/pictures.h"

namespace surfit {
namespace {

constexpr Rgb8 kSourceColor = {240, 130, 20};
constexpr Rgb8 kTargetColor = {30, 110, 220};

std::vector<Eigen::Vector3f> PointsOf(const FrameLevel& level, const Rigid3d& frame_from_camera) {
  const Eigen::Matrix3f rotation = frame_from_camera.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f translation = frame_from_camera.translation.cast<float>();
  std::vector<Eigen::Vector3f> points;
  for (int v = 0; v < level.vertex.height(); ++v) {
    for (int u = 0; u < level.vertex.width(); ++u) {
      const Eigen::Vector3f point = level.vertex(u, v);
      if (point.z() > 0) points.emplace_back(rotation * point + translation);
    }
  }
  return points;
}

void WriteClouds(const PosedView& source, const PosedView& target,
                 const Rigid3d& target_from_source, const std::string& stem) {
  const auto source_points = PointsOf(source.view.pyramid.levels.front(), target_from_source);
  const auto target_points = PointsOf(target.view.pyramid.levels.front(), Rigid3d());
  WriteTwoCloudPicture(source_points, target_points, stem + ".png");
  PointCloud both;
  both.points = source_points;
  both.points.insert(both.points.end(), target_points.begin(), target_points.end());
  both.colors.assign(source_points.size(), kSourceColor);
  both.colors.resize(both.points.size(), kTargetColor);
  WritePly(both, stem + ".ply");
}

PoseError ErrorOf(const Rigid3d& estimated, const Rigid3d& truth) {
  const Rigid3d difference = truth.Inverse() * estimated;
  return {difference.translation.norm(), RotationAngle(difference.rotation) * 180 / M_PI};
}

}  // namespace

AlignRunResult RunAlign(const AlignRunOptions& options) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  PosedView source = ReadPosedView(options.sequence, options.source, options.preprocess);
  PosedView target = ReadPosedView(options.sequence, options.target, options.preprocess);
  if (options.icp.error_model.UsesIntensities()) {
    for (PosedView* posed : {&source, &target}) {
      AddIntensity(posed->view.color, &posed->view.pyramid);
    }
  }
  PrepareOutputFolder(options.output, {"before.ply", "after.ply", "before.png", "after.png"});

  AlignRunResult result;
  result.registration =
      InitializeAndRegister(source.view, target.view, options.initialize, options.icp);
  const Rigid3d& estimated = result.registration.icp.target_from_source;
  if (source.world_from_camera && target.world_from_camera) {
    const Rigid3d truth = target.world_from_camera->Inverse() * *source.world_from_camera;
    result.initial_error = ErrorOf(Rigid3d(), truth);
    result.final_error = ErrorOf(estimated, truth);
  }
  WriteClouds(source, target, Rigid3d(), options.output + "/before");
  WriteClouds(source, target, estimated, options.output + "/after");
  return result;
}

}  // namespace surfit
