#include <omp.h>
#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/pipelines/odometry/Odometry.h>

#include "benchmarks/peers/peer.h"

namespace surfit::testing {
namespace {

namespace o3d = open3d::pipelines::odometry;
using open3d::geometry::Image;
using open3d::geometry::RGBDImage;

// Frame-to-frame odometry with the default hybrid term of brightness and depth (depth up to 4 m).
class Open3dSlamPeer final : public SlamPeer {
 public:
  explicit Open3dSlamPeer(const PinholeCamera& c)
      : intrinsic_(c.width, c.height, c.fx, c.fy, c.cx, c.cy) {}

  void SetFrame(const RgbdFrame& frame) override {
    const int width = frame.depth_m.width(), height = frame.depth_m.height();
    frame_ = std::make_shared<RGBDImage>();
    frame_->color_.Prepare(width, height, 1, sizeof(float));
    frame_->depth_.Prepare(width, height, 1, sizeof(float));
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const Rgb8 c = frame.color(u, v);
        *frame_->color_.PointerAt<float>(u, v) =
            (0.299f * c.r + 0.587f * c.g + 0.114f * c.b) / 255.f;
        *frame_->depth_.PointerAt<float>(u, v) = frame.depth_m(u, v);
      }
    }
  }

  std::optional<Rigid3d> Track() override {
    if (last_) {
      const auto [succeeded, last_from_this, information] =
          o3d::ComputeRGBDOdometry(*frame_, *last_, intrinsic_);
      if (!succeeded) return std::nullopt;
      const Eigen::Quaterniond rotation(Eigen::Matrix3d(last_from_this.topLeftCorner<3, 3>()));
      world_from_last_ =
          world_from_last_ * Rigid3d(rotation.normalized(), last_from_this.topRightCorner<3, 1>());
    }
    last_ = frame_;
    return world_from_last_;
  }

 private:
  open3d::camera::PinholeCameraIntrinsic intrinsic_;
  std::shared_ptr<RGBDImage> frame_, last_;
  Rigid3d world_from_last_;
};

}  // namespace

std::unique_ptr<SlamPeer> MakeOpen3dSlamPeer(const PinholeCamera& camera, int threads) {
  omp_set_num_threads(threads);
  return std::make_unique<Open3dSlamPeer>(camera);
}

}  // namespace surfit::testing
