#include <omp.h>
#include <open3d/t/pipelines/slam/Model.h>
#include <open3d/utility/Logging.h>

#include <array>
#include <cmath>

#include "benchmarks/peers/peer.h"

namespace surfit::testing {
namespace {

namespace o3c = open3d::core;
namespace o3g = open3d::t::geometry;
namespace o3o = open3d::t::pipelines::odometry;
namespace slam = open3d::t::pipelines::slam;

// Default configuration of the dense SLAM examples of Open3D, in metres except the depth scale.
constexpr float kVoxelSize = 3.f / 512;
constexpr float kDepthScale = 1000, kDepthMin = 0.1f, kDepthMax = 3;
constexpr float kTruncationInVoxels = 8;
constexpr float kLargestDepthDifference = 0.07f;
constexpr std::array<int, 3> kIterations = {6, 3, 1};  // coarse to fine
constexpr int kBlockResolution = 16, kBlocks = 40000;

o3c::Tensor Intrinsics(const PinholeCamera& c) {
  return o3c::Tensor::Init<double>({{c.fx, 0, c.cx}, {0, c.fy, c.cy}, {0, 0, 1}});
}

Rigid3d ToRigid(const o3c::Tensor& matrix) {
  const auto at = [&](int row, int column) { return matrix[row][column].Item<double>(); };
  Eigen::Matrix3d rotation;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation(row, column) = at(row, column);
  }
  return {Eigen::Quaterniond(rotation).normalized(), {at(0, 3), at(1, 3), at(2, 3)}};
}

struct DepthPyramid {
  struct Level {
    o3c::Tensor vertices, normals, intrinsics;
  };
  std::array<Level, kIterations.size()> levels;
};

o3c::Tensor Halved(const o3c::Tensor& intrinsics) {
  o3c::Tensor halved = intrinsics / 2;
  halved[2][2] = 1;
  return halved;
}

// As RGBDOdometryMultiScale(), without the bilateral filter before normals. Open3D of Debian is
// built without Intel IPP: Image::FilterBilateral() throws on a CPU. So RGBDOdometryMultiScale()
// and Model::TrackFrameToModel() throw as well.
DepthPyramid MakePyramid(const o3c::Tensor& depth, o3c::Tensor intrinsics) {
  DepthPyramid pyramid;
  o3g::Image image = o3g::Image(depth).ClipTransform(kDepthScale, 0, kDepthMax, NAN);
  for (auto level = pyramid.levels.rbegin(); level != pyramid.levels.rend(); ++level) {
    o3g::Image vertices = image.CreateVertexMap(intrinsics, NAN);
    *level = {vertices.AsTensor(), vertices.CreateNormalMap(NAN).AsTensor(), intrinsics};
    if (level + 1 == pyramid.levels.rend()) break;
    image = image.PyrDownDepth(2 * kLargestDepthDifference, NAN);
    intrinsics = Halved(intrinsics);
  }
  return pyramid;
}

o3c::Tensor AlignDepth(const DepthPyramid& source, const DepthPyramid& target) {
  const o3o::OdometryLossParams loss(kLargestDepthDifference);
  auto target_from_source = o3c::Tensor::Eye(4, o3c::Float64, o3c::Device("CPU:0"));
  for (std::size_t i = 0; i < kIterations.size(); ++i) {
    for (int iteration = 0; iteration < kIterations[i]; ++iteration) {
      const auto step = o3o::ComputeOdometryResultPointToPlane(
          source.levels[i].vertices, target.levels[i].vertices, target.levels[i].normals,
          source.levels[i].intrinsics, target_from_source, loss.depth_outlier_trunc_,
          loss.depth_huber_delta_);
      target_from_source = step.transformation_.Matmul(target_from_source);
    }
  }
  return target_from_source;
}

// Frame-to-model SLAM: a truncated signed distance field in hashed blocks, ray casting from the
// last pose, depth odometry (point to plane, three scales) and integration.
class Open3dModelPeer final : public SlamPeer {
 public:
  explicit Open3dModelPeer(const PinholeCamera& c)
      : model_(kVoxelSize, kBlockResolution, kBlocks, Identity(), cpu_),
        frame_(c.height, c.width, Intrinsics(c), cpu_),
        ray_cast_(c.height, c.width, Intrinsics(c), cpu_) {}

  void SetFrame(const RgbdFrame& frame) override {
    const int width = frame.depth_m.width(), height = frame.depth_m.height();
    o3c::Tensor depth({height, width, 1}, o3c::UInt16, cpu_);
    o3c::Tensor color({height, width, 3}, o3c::UInt8, cpu_);
    auto* depths = depth.GetDataPtr<std::uint16_t>();
    auto* colors = color.GetDataPtr<std::uint8_t>();
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        *depths++ = static_cast<std::uint16_t>(std::lround(kDepthScale * frame.depth_m(u, v)));
        const Rgb8 c = frame.color(u, v);
        for (const std::uint8_t value : {c.r, c.g, c.b}) *colors++ = value;
      }
    }
    frame_.SetData("depth", depth);
    frame_.SetData("color", color);
  }

  std::optional<Rigid3d> Track() override {
    if (index_ > 0) {
      const o3c::Tensor last_from_frame =
          AlignDepth(MakePyramid(frame_.GetData("depth"), frame_.GetIntrinsics()),
                     MakePyramid(ray_cast_.GetData("depth"), ray_cast_.GetIntrinsics()));
      world_from_frame_ = world_from_frame_.Matmul(last_from_frame);
    }
    model_.UpdateFramePose(index_++, world_from_frame_);
    model_.Integrate(frame_, kDepthScale, kDepthMax, kTruncationInVoxels);
    model_.SynthesizeModelFrame(ray_cast_, kDepthScale, kDepthMin, kDepthMax, kTruncationInVoxels,
                                false);
    return ToRigid(world_from_frame_);
  }

 private:
  o3c::Tensor Identity() const { return o3c::Tensor::Eye(4, o3c::Float64, cpu_); }

  const o3c::Device cpu_ = o3c::Device("CPU:0");
  slam::Model model_;
  slam::Frame frame_, ray_cast_;
  o3c::Tensor world_from_frame_ = Identity();
  int index_ = 0;
};

}  // namespace

std::unique_ptr<SlamPeer> MakeOpen3dModelPeer(const PinholeCamera& camera, int threads) {
  omp_set_num_threads(threads);
  open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error);
  return std::make_unique<Open3dModelPeer>(camera);
}

}  // namespace surfit::testing
