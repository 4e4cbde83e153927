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

// What every library gets: the same points with the same normals (unit length, none missing).
struct PeerCloud {
  std::vector<Eigen::Vector3f> points, normals;
};

// Under which rules a library registers.
struct PeerRules {
  double max_distance_m = 0.1;
  int threads = 1;
  // Whether it iterates as it does by default, or by the common rule: at most 30 steps, and an end
  // where RMSE changes by less than 0.1 %, or as near to that as the library can be told.
  bool own_criteria = true;

  static constexpr int kMaxIterations = 30;
  static constexpr double kMinRelativeRmseChange = 1e-3;
};

// A library that registers clouds by point-to-plane ICP with nearest neighbours.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string name() const = 0;
  // Turns the clouds into what the library takes; not timed.
  virtual void SetClouds(const PeerCloud& source, const PeerCloud& target) = 0;
  // target_from_source, started at the identity; timed, with all trees that it needs.
  virtual Eigen::Matrix4d Register(const PeerRules& rules) = 0;
};

std::unique_ptr<Peer> MakeSurfitPeer();
std::unique_ptr<Peer> MakePclPeer();
std::unique_ptr<Peer> MakeOpen3dPeer();

// A system that follows an RGB-D camera.
class SlamPeer {
 public:
  virtual ~SlamPeer() = default;
  // Turns the next frame into what the library takes; not timed.
  virtual void SetFrame(const RgbdFrame& frame) = 0;
  // world_from_camera of that frame, the first camera being the world; nothing if lost. Timed.
  virtual std::optional<Rigid3d> Track() = 0;
};

using MakeSlamPeer = std::unique_ptr<SlamPeer> (*)(const PinholeCamera& camera, int threads);

std::unique_ptr<SlamPeer> MakeSurfitSlamPeer(const PinholeCamera& camera, int threads);
std::unique_ptr<SlamPeer> MakeOpencvSlamPeer(const PinholeCamera& camera, int threads);
std::unique_ptr<SlamPeer> MakeOpen3dSlamPeer(const PinholeCamera& camera, int threads);
std::unique_ptr<SlamPeer> MakeOpen3dModelPeer(const PinholeCamera& camera, int threads);

}  // namespace surfit::testing
