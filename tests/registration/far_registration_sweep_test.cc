// Registers frames at a distance of 90 frames by features and geometry, and counts the results.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "registration/global/view_fit.h"
#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/global_registration.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/pixels.h"
#include "testing/shared_data.h"

namespace surfit::testing {
namespace {

constexpr int kGap = 90;
constexpr double kEnoughOverlap = 0.3;

struct PosedView {
  ColoredView view;
  Rigid3d world_from_camera;
};

// Numbers of frame pairs.
struct Outcome {
  int pairs = 0;
  int enough = 0;   // overlap above kEnoughOverlap
  int right = 0;    // converged near the ground truth, with enough overlap
  int wrong = 0;    // converged elsewhere, with any overlap
  int refused = 0;  // did not converge

  Outcome& operator+=(const Outcome& other) {
    pairs += other.pairs;
    enough += other.enough;
    right += other.right;
    wrong += other.wrong;
    refused += other.refused;
    return *this;
  }
};

// Ratio of source points that are visible in the target. A point is visible if its distance to the
// target surface is within kFreeSpaceSigmas of the depth noise of both views.
double TrueOverlap(const FrameLevel& source, const FrameLevel& target,
                   const Rigid3d& target_from_source) {
  const ErrorModel error_model;
  const DepthNoise noise;
  int valid = 0, seen = 0;
  for (const auto [u, v] : PixelsOf(source.vertex)) {
    if (!(source.vertex.z(u, v) > 0)) continue;
    ++valid;
    const Eigen::Vector3d point = target_from_source * source.vertex(u, v).cast<double>();
    if (!(point.z() > 0)) continue;
    const Eigen::Vector2d pixel = target.camera.Project(point);
    const auto x = std::lround(pixel.x()), y = std::lround(pixel.y());
    if (x < 0 || y < 0 || x >= target.camera.width || y >= target.camera.height) continue;
    const auto at_u = static_cast<int>(x), at_v = static_cast<int>(y);
    const Eigen::Vector3d surface = target.vertex(at_u, at_v).cast<double>();
    const Eigen::Vector3d normal = target.normal(at_u, at_v).cast<double>();
    if (!(surface.z() > 0) || normal.isZero(0)) continue;
    const double sigma_m =
        std::hypot(error_model.Sigma(point.z(), noise), noise.SigmaZ(surface.z()));
    seen += std::abs(normal.dot(point - surface)) <= kFreeSpaceSigmas * sigma_m;
  }
  return valid > 0 ? static_cast<double>(seen) / valid : 0;
}

struct Bound {
  double distance_m = 0.02;
  double angle_deg = 1;
  // True: dense ICP from the recorded pose gives the ground truth, because the error of the
  // recorded poses is larger than the bound.
  bool refine_truth = false;
};

Outcome RegisterPair(const PosedView& source, const PosedView& target, const Bound& bound) {
  const IcpOptions icp = GlobalIcpOptions();
  InitializeOptions options;
  options.method = "features";
  Rigid3d truth = target.world_from_camera.Inverse() * source.world_from_camera;
  if (bound.refine_truth) {
    IcpOptions anywhere = IcpOptionsFromStart(options, icp);
    anywhere.max_free_space_violation_ratio = 1;
    truth = Register(source.view.pyramid, target.view.pyramid, truth, anywhere).target_from_source;
  }
  const GlobalRegistrationResult result = RegisterGlobally(source.view, target.view, options, icp);
  const Rigid3d error = truth.Inverse() * result.icp.target_from_source;
  const double off_m = error.translation.norm();
  const double off_deg = RotationAngle(error.rotation) * 180 / M_PI;
  const bool near = off_m <= bound.distance_m && off_deg <= bound.angle_deg;
  const double overlap =
      TrueOverlap(source.view.pyramid.levels.front(), target.view.pyramid.levels.front(), truth);
  const bool is_enough = overlap > kEnoughOverlap, converged = result.accepted();
  return {1, is_enough, is_enough && converged && near, converged && !near, !converged};
}

// The distance of consecutive views is `stride` frames.
Outcome RegisterPairs(int stride, const Bound& bound,
                      const std::function<std::optional<PosedView>()>& next_view) {
  const std::size_t gap = kGap / stride;
  std::deque<PosedView> last;
  Outcome outcome;
  while (std::optional<PosedView> view = next_view()) {
    last.push_back(std::move(*view));
    if (last.size() <= gap) continue;
    outcome += RegisterPair(last.front(), last.back(), bound);
    last.pop_front();
  }
  return outcome;
}

Outcome RegisterRecorded(const std::string& sequence, int stride, const Bound& bound) {
  SequenceOptions options;
  options.path = SharedData(sequence);
  options.stride = stride;
  const std::unique_ptr<FrameSource> source = OpenSequence(options);
  const SequenceInfo& info = source->info();
  return RegisterPairs(stride, bound, [&]() -> std::optional<PosedView> {
    std::optional<ReadResult> read = source->Next();
    if (!read) return std::nullopt;
    return PosedView{
        {PreprocessDepth(read->frame->depth_m, info.sensor(), {}), std::move(read->frame->color)},
        InterpolatePose(info.ground_truth, read->stamp_s).value()};
  });
}

Outcome RegisterSimulated(std::uint64_t seed, int stride) {
  constexpr int kFrames = 200;
  const PinholeCamera camera = {640, 480, 525, 525, 319.5, 239.5, {}};
  const Scene scene = MakeScene("room", seed);
  const Trajectory path = MakePath(scene, kFrames, seed);
  int index = -stride;
  return RegisterPairs(stride, {}, [&]() -> std::optional<PosedView> {
    index += stride;
    if (index >= kFrames) return std::nullopt;
    const Rigid3d& pose = path[index].world_from_camera;
    Rendering image = Render(scene, camera, pose);
    const Image<float> depth_m = KinectDepth(image.depth_m, camera, (seed << 32) + index);
    return PosedView{{PreprocessDepth(depth_m, {camera, {}}, {}), std::move(image.color)}, pose};
  });
}

void Print(const std::string& name, const Outcome& outcome) {
  std::printf("%-22s %6d %10d %6d %6d %8d\n", name.c_str(), outcome.pairs, outcome.enough,
              outcome.right, outcome.wrong, outcome.refused);
  std::fflush(stdout);
}

// The bound is 2 cm and 1 degree. The poses of the kitchen are from another system: the bound is 3
// cm and 1 degree from the result of dense ICP. Uses every 5th pair, and every 10th pair of kitchen
// and rooms. The options were tuned on other rooms (seeds 11 to 20).
TEST(FarPairsSweep, AreRegisteredOrRejected) {
  SURFIT_REQUIRE_SHARED_DATA("icl_office");
  SURFIT_REQUIRE_SHARED_DATA("icl_office_kinect");
  SURFIT_REQUIRE_SHARED_DATA("seven_scenes_kitchen");
  std::printf("%-22s  pairs above 30 %%  right  wrong  refused\n", "90 frames apart");
  Outcome all;
  const auto add = [&](const std::string& name, const Outcome& outcome) {
    Print(name, outcome);
    EXPECT_GE(outcome.right, 0.9 * outcome.enough) << name;
    all += outcome;
  };
  for (const auto& [name, stride, bound] :
       {std::tuple{"icl_office", 5, Bound()}, std::tuple{"icl_office_kinect", 5, Bound()},
        std::tuple{"seven_scenes_kitchen", 10, Bound{0.03, 1, true}}}) {
    add(name, RegisterRecorded(name, stride, bound));
  }
  Outcome rooms;
  for (const std::uint64_t seed : {21, 22, 23, 24, 25, 26, 27, 28}) {
    const Outcome outcome = RegisterSimulated(seed, 10);
    Print("room " + std::to_string(seed), outcome);
    rooms += outcome;
  }
  add("all rooms", rooms);
  Print("all", all);
  EXPECT_LE(all.wrong, 0.02 * all.pairs);
}

}  // namespace
}  // namespace surfit::testing
