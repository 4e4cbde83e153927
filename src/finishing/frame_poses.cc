#include "finishing/frame_poses.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "finishing/color_registration.h"
#include "surfit/frame/preprocess.h"
#include "surfit/optimization/keyframes.h"
#include "surfit/registration/icp.h"

namespace surfit {
namespace {

constexpr int kColumns = 320;
constexpr double kTracked_m = 0.005, kTracked_rad = 0.005;
constexpr double kSigmaRatio = 3;
constexpr double kMaxCostRatio = 0.99;
constexpr double kMaxDistance2 = 38;  // chi-square, 6 degrees of freedom, probability 1e-6

// Covariance of a pose of the run.
Matrix6d OfRun() { return Variances(kTracked_rad, kTracked_m); }

IcpOptions WithPrior(IcpOptions options) {
  options.association = "projective";
  if (options.solver == "svd") options.solver = IcpOptions().solver;  // svd has no prior
  return options;
}

Image<float> EveryNth(const Image<float>& image, int n) {
  Image<float> samples((image.width() + n - 1) / n, (image.height() + n - 1) / n);
  for (int v = 0; v < samples.height(); ++v) {
    for (int u = 0; u < samples.width(); ++u) samples(u, v) = image(n * u, n * v);
  }
  return samples;
}

}  // namespace

FramePoses::FramePoses(const PosedSequence& known, const DepthSensor& sensor, const SurfelMap& map)
    : known_(known),
      map_(map),
      icp_(WithPrior(known.slam.icp)),
      coarse_(sensor),
      sampled_(sensor),
      step_(std::max(1, sensor.camera.width / kColumns)) {
  coarse_.camera = sensor.camera.Binned(step_);
  sampled_.camera = sensor.camera.Subsampled(step_);
}

FinalPose FramePoses::Register(const FinalFrame& of) {
  const double offset_s = of.frame.color_stamp_s - of.frame.stamp_s;
  const ModelView view = renderer_.Render(map_, coarse_, of.world_from_camera);
  const Rigid3d of_run = ExtrapolatePose(of.world_from_camera, of.motion, offset_s);
  ExpectedColorPose expected = {of_run};
  if (const std::optional<DepthPose> by_depth = RegisterDepth(of, view)) {
    expected = {ExtrapolatePose(by_depth->world_from_camera, of.motion, offset_s),
                by_depth->information};
  }
  const RegisteredColors by_color =
      RegisterColors(of.frame.color, DrawnDiscs(view, map_), coarse_, of.motion,
                     of.world_from_camera, expected, of_run);
  const Vector6d change = FirstOrderIncrement(of_run, by_color.world_from_color);
  if (!(change.dot(OfRun().ldlt().solve(change)) < kMaxDistance2))
    return {of.world_from_camera, of_run};
  return {ExtrapolatePose(by_color.world_from_color, of.motion, -offset_s),
          by_color.world_from_color, by_color.cost_before, by_color.cost_after};
}

std::optional<FramePoses::DepthPose> FramePoses::RegisterDepth(const FinalFrame& of,
                                                               const ModelView& view) const {
  const FramePyramid pyramid =
      PreprocessDepth(EveryNth(of.depth_m, step_), sampled_, known_.slam.preprocess);
  const FramePyramid source = {{pyramid.levels.size() > 1 ? pyramid.levels[1] : pyramid.levels[0]}};
  const FramePyramid target = {{pyramid.levels.size() > 1
                                    ? HalfResolution(view.surface, known_.slam.preprocess)
                                    : view.surface}};
  const PriorTerm prior = {Rigid3d(), kSharedPoints * OfRun().inverse()};
  const IcpResult icp = RegisterWithPrior(source, target, Rigid3d(), prior, icp_);
  if (!icp.Succeeded()) return std::nullopt;
  const std::optional<Matrix6d> covariance =
      CovarianceByBlocks(source, target, icp.target_from_source, icp_);
  if (!covariance) return std::nullopt;
  return DepthPose{of.world_from_camera * icp.target_from_source,
                   (kSigmaRatio * kSigmaRatio * *covariance).inverse()};
}

Trajectory WithFinalPoses(const Trajectory& trajectory,
                          const std::vector<std::optional<FinalPose>>& poses) {
  std::vector<std::size_t> registered;
  std::vector<Rigid3d> world_from_camera;
  double before = 0, after = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i] || poses[i]->cost_before == 0) continue;
    registered.push_back(i);
    world_from_camera.push_back(poses[i]->world_from_camera);
    before += poses[i]->cost_before;
    after += poses[i]->cost_after;
  }
  if (registered.empty() || after > kMaxCostRatio * before) return trajectory;
  return CorrectTrajectory(trajectory, registered, world_from_camera);
}

}  // namespace surfit
