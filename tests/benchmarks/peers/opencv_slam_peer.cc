#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd.hpp>

#include "benchmarks/peers/peer.h"

namespace surfit::testing {
namespace {

// Frame-to-frame odometry with the default combination of brightness and ICP (depth up to 4 m).
// Data computed for a frame are reused for the next frame.
class OpencvSlamPeer final : public SlamPeer {
 public:
  explicit OpencvSlamPeer(const PinholeCamera& c) {
    const cv::Mat matrix = (cv::Mat_<float>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
    odometry_ = cv::rgbd::RgbdICPOdometry::create(matrix);
  }

  void SetFrame(const RgbdFrame& frame) override {
    const cv::Size size(frame.depth_m.width(), frame.depth_m.height());
    // The images are copied immediately.
    const cv::Mat color(size, CV_8UC3, const_cast<Rgb8*>(frame.color.data()));
    const cv::Mat depth_m(size, CV_32FC1, const_cast<float*>(frame.depth_m.data()));
    cv::Mat gray;
    cv::cvtColor(color, gray, cv::COLOR_RGB2GRAY);
    frame_ = cv::rgbd::OdometryFrame::create(gray, depth_m.clone(), depth_m > 0);
  }

  std::optional<Rigid3d> Track() override {
    cv::Mat last_from_this;
    if (last_ && !odometry_->compute(frame_, last_, last_from_this)) return std::nullopt;
    if (last_) {
      const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(
          last_from_this.ptr<double>());
      const Eigen::Quaterniond rotation(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()));
      world_from_last_ =
          world_from_last_ * Rigid3d(rotation.normalized(), matrix.topRightCorner<3, 1>());
    }
    last_ = frame_;
    return world_from_last_;
  }

 private:
  cv::Ptr<cv::rgbd::RgbdICPOdometry> odometry_;
  cv::Ptr<cv::rgbd::OdometryFrame> frame_, last_;
  Rigid3d world_from_last_;
};

}  // namespace

std::unique_ptr<SlamPeer> MakeOpencvSlamPeer(const PinholeCamera& camera, int threads) {
  cv::setNumThreads(threads);
  return std::make_unique<OpencvSlamPeer>(camera);
}

}  // namespace surfit::testing
