#include "benchmarks/peers/peer.h"
#include "surfit/core/parallel.h"
#include "surfit/slam/slam.h"

namespace surfit::testing {
namespace {

// Frame-to-model SLAM with a map.
class SurfitSlamPeer final : public SlamPeer {
 public:
  SurfitSlamPeer(const PinholeCamera& camera, int threads)
      : limit_(threads), slam_({camera, {}}, SlamOptions(), Rigid3d()) {}

  void SetFrame(const RgbdFrame& frame) override { frame_ = frame; }

  std::optional<Rigid3d> Track() override {
    const FrameReport report = slam_.Process(frame_);
    if (report.state == FrameState::kLost) return std::nullopt;
    return report.world_from_camera;
  }

 private:
  ThreadLimit limit_;
  Slam slam_;
  RgbdFrame frame_;
};

}  // namespace

std::unique_ptr<SlamPeer> MakeSurfitSlamPeer(const PinholeCamera& camera, int threads) {
  return std::make_unique<SurfitSlamPeer>(camera, threads);
}

}  // namespace surfit::testing
