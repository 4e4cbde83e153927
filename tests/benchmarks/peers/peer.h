#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit::testing {

// Input of all libraries: the same points and the same normals, of unit length.
struct PeerCloud {
  std::vector<Eigen::Vector3f> points, normals;
};

struct PeerRules {
  double max_distance_m = 0.1;
  int threads = 1;
  // True: default termination criteria of the library. False: common criteria, at most 30
  // iterations and a relative RMSE change below 0.1 %, or the closest setting of the library.
  bool own_criteria = true;

  static constexpr int kMaxIterations = 30;
  static constexpr double kMinRelativeRmseChange = 1e-3;
};

// Registers point clouds by point-to-plane ICP with nearest neighbours.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string name() const = 0;
  // Converts the clouds to the types of the library; not timed.
  virtual void SetClouds(const PeerCloud& source, const PeerCloud& target) = 0;
  // Returns target_from_source. The initial pose is the identity. Timed, including all search
  // trees.
  virtual Eigen::Matrix4d Register(const PeerRules& rules) = 0;
};

std::unique_ptr<Peer> MakeSurfitPeer();
std::unique_ptr<Peer> MakePclPeer();
std::unique_ptr<Peer> MakeOpen3dPeer();

class SlamPeer {
 public:
  virtual ~SlamPeer() = default;
  // Converts the next frame to the types of the library; not timed.
  virtual void SetFrame(const RgbdFrame& frame) = 0;
  // Returns world_from_camera of the frame, relative to the first frame. std::nullopt: lost. Timed.
  virtual std::optional<Rigid3d> Track() = 0;
};

using MakeSlamPeer = std::unique_ptr<SlamPeer> (*)(const PinholeCamera& camera, int threads);

std::unique_ptr<SlamPeer> MakeSurfitSlamPeer(const PinholeCamera& camera, int threads);
std::unique_ptr<SlamPeer> MakeOpencvSlamPeer(const PinholeCamera& camera, int threads);
std::unique_ptr<SlamPeer> MakeOpen3dSlamPeer(const PinholeCamera& camera, int threads);
std::unique_ptr<SlamPeer> MakeOpen3dModelPeer(const PinholeCamera& camera, int threads);

}  // namespace surfit::testing
