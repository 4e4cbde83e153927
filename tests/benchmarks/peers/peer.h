#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

namespace surfit {

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

}  // namespace surfit
