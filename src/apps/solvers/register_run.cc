#include "apps/solvers/register_run.h"

#include <fstream>
#include <functional>
#include <iomanip>
#include <iterator>
#include <vector>

#include "apps/solvers/cloud_file.h"
#include "apps/solvers/result_json.h"
#include "io/files/output_folder.h"
#include "output/output_files.h"
#include "output/pictures/pictures.h"
#include "run/posed_views.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

constexpr Rgb8 kSourcePaint = {240, 130, 20};
constexpr Rgb8 kTargetPaint = {30, 110, 220};

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

void WriteClouds(const PosedPair& pair, const Rigid3d& target_from_source,
                 const std::string& stem) {
  const auto source_points = PointsOf(pair.source.view.pyramid.levels.front(), target_from_source);
  const auto target_points = PointsOf(pair.target.view.pyramid.levels.front(), Rigid3d());
  WriteTwoCloudPicture(source_points, target_points, stem + ".png");
  PointCloud both;
  both.points = source_points;
  both.points.insert(both.points.end(), target_points.begin(), target_points.end());
  both.colors.assign(source_points.size(), kSourcePaint);
  both.colors.resize(both.points.size(), kTargetPaint);
  WritePly(both, stem + ".ply");
}

// Coordinates of the result are relative to `origin`.
PointCloud Moved(PointCloud cloud, const Rigid3d& pose, const Eigen::Vector3d& origin) {
  for (auto& point : cloud.points) {
    point = (pose * (point.cast<double>() + cloud.origin) - origin).cast<float>();
  }
  cloud.origin = origin;
  for (auto& normal : cloud.normals) normal = (pose.rotation * normal.cast<double>()).cast<float>();
  return cloud;
}

void WriteTransform(const Rigid3d& pose, const std::string& path) {
  const Eigen::Matrix4d matrix = pose.Matrix();
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << std::setprecision(17);
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        file << matrix(row, column) << (column < 3 ? ' ' : '\n');
      }
    }
  });
}

std::optional<Rigid3d> ReadStartPose(const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text.find(',') != std::string::npos) return ParsePose("start_pose", text);
  std::ifstream file(text);
  ThrowIf(!file, "start_pose is '", text,
          "', must be tx,ty,tz,qx,qy,qz,qw or a file with a 4 x 4 matrix");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) file >> matrix(i / 4, i % 4);
  std::string rest;
  ThrowIf(!file || file >> rest, text, ": must contain the 16 numbers of a 4 x 4 matrix");
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  constexpr double kTolerance = 1e-3;  // rounding error of a matrix that is written with few digits
  const bool is_rigid = matrix.allFinite() && rotation.determinant() > 0 &&
                        (rotation * rotation.transpose()).isIdentity(kTolerance) &&
                        matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kTolerance);
  ThrowIf(!is_rigid, text, ": the matrix must be a rotation and a translation");
  return Rigid3d(rotation, matrix.topRightCorner<3, 1>());
}

// Mean of the points, in the frame of the file.
Eigen::Vector3d CenterOf(const PreparedCloud& prepared) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& point : prepared.points.points) sum += point.cast<double>();
  return prepared.cloud.origin + sum / static_cast<double>(prepared.points.size());
}

SensedCloud CloudAbout(const Eigen::Vector3d& center, const PreparedCloud& prepared,
                       const RegisterRunOptions& options) {
  SensedCloud cloud;
  cloud.points = prepared.points;
  for (Eigen::Vector3f& point : cloud.points.points) {
    point = (point.cast<double>() + prepared.cloud.origin - center).cast<float>();
  }
  cloud.viewpoint = options.sensor.viewpoint - center;
  cloud.has_viewpoint = options.single_view;
  cloud.has_signed_normals = prepared.has_signed_normals;
  return cloud;
}

Rigid3d Shift(const Eigen::Vector3d& translation) {
  return {Eigen::Quaterniond::Identity(), translation};
}

// Moves the origins of both frames. A left perturbation (w, v) about the centre c of the target is
// (w, v + c x w) in the frame of the file.
void MoveOrigins(const Eigen::Vector3d& source_center, const Eigen::Vector3d& target_center,
                 IcpResult* icp) {
  icp->target_from_source = Shift(target_center) * icp->target_from_source * Shift(-source_center);
  Matrix6d moved = Matrix6d::Identity(), back = moved;
  moved.bottomLeftCorner<3, 3>() = CrossMatrix<double>(target_center);
  back.bottomLeftCorner<3, 3>() = -CrossMatrix<double>(target_center);
  icp->information = back.transpose() * icp->information * back;
  icp->trusted_information = back.transpose() * icp->trusted_information * back;
  if (icp->covariance) *icp->covariance = moved * *icp->covariance * moved.transpose();
  for (Vector6d& direction : icp->degenerate_directions) direction = moved * direction;
}

CloudRegistration RegisterAboutCenters(const PreparedCloud& source, const PreparedCloud& target,
                                       const RegisterRunOptions& options) {
  const Eigen::Vector3d source_center = CenterOf(source), target_center = CenterOf(target);
  const Rigid3d given = ReadStartPose(options.start_pose).value_or(Rigid3d());
  CloudStartOptions start = options.start;
  // Without an initial pose, the given pose is the identity in the frames of the files.
  if (start.method == "identity") start.method = "file";
  CloudRegistration result = RegisterCloudsFrom(
      CloudAbout(source_center, source, options), CloudAbout(target_center, target, options),
      Shift(-target_center) * given * Shift(source_center), start, options.registration);
  if (result.start == "file" && options.start_pose.empty()) result.start = "identity";
  MoveOrigins(source_center, target_center, &result.icp);
  return result;
}

}  // namespace

AlignRunResult RunAlign(const AlignRunOptions& options) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  const PosedPair pair = ReadPosedPair(options.sequence, options.source, options.target,
                                       options.preprocess, options.icp.error_model);
  const OutputFolder owned(options.output, {"transform.txt", "registration.json", "before.ply",
                                            "after.ply", "before.png", "after.png"});

  AlignRunResult result;
  result.registration =
      RegisterGlobally(pair.source.view, pair.target.view, options.initialize, options.icp);
  IcpResult& icp = result.registration.icp;
  icp.covariance =
      CovarianceOfViews(pair.source.view.pyramid, pair.target.view.pyramid, icp, options.icp);
  const Rigid3d& estimated = icp.target_from_source;
  if (const std::optional<Rigid3d> truth = pair.TargetFromSource()) {
    result.initial_error = ErrorOf(Rigid3d(), *truth);
    result.final_error = ErrorOf(estimated, *truth);
  }
  WriteTransform(estimated, options.output + "/transform.txt");
  WriteAlignmentJson(result, options, options.output + "/registration.json");
  WriteClouds(pair, Rigid3d(), options.output + "/before");
  WriteClouds(pair, estimated, options.output + "/after");
  return result;
}

RegisterRunResult RunRegister(const RegisterRunOptions& options) {
  Validate(options);
  ReadStartPose(options.start_pose);  // throws before the clouds are read
  ThrowIf(options.start.method == "file" && options.start_pose.empty(),
          "start is 'file', but start_pose is empty");
  ThrowIf((options.start.method == "identity" || options.start.method == "global") &&
              !options.start_pose.empty(),
          "start_pose has no effect with start '", options.start.method,
          "', must be empty or start must be 'file' or 'auto'");
  const ThreadLimit limit(options.threads);
  RegisterRunResult result;
  const double floor_sigma_m = options.registration.icp.error_model.floor_sigma_m;
  const PreparedCloud source =
      ReadCloudFile(options.source, options.sensor, options.normals, floor_sigma_m);
  const PreparedCloud target =
      ReadCloudFile(options.target, options.sensor, options.normals, floor_sigma_m);
  result.source = source.about;
  result.target = target.about;
  const OutputFolder owned(options.output, {"transform.txt", "registration.json", "aligned.ply",
                                            "before.png", "after.png"});
  result.registration = RegisterAboutCenters(source, target, options);
  const Rigid3d& pose = result.registration.icp.target_from_source;
  const Eigen::Vector3d& origin = target.cloud.origin;
  const PointCloud aligned = Moved(source.cloud, pose, origin);
  WriteTransform(pose, options.output + "/transform.txt");
  WriteRegistrationJson(result, options, options.output + "/registration.json");
  const std::function<void()> writers[] = {
      [&] {
        WriteTwoCloudPicture(Moved(source.cloud, Rigid3d(), origin).points, target.cloud.points,
                             options.output + "/before.png");
      },
      [&] {
        WriteTwoCloudPicture(aligned.points, target.cloud.points, options.output + "/after.png");
      },
      [&] { WritePly(aligned, options.output + "/aligned.ply"); }};
  ParallelFor(0, static_cast<int>(std::size(writers)), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) writers[i]();
  });
  return result;
}

}  // namespace surfit
