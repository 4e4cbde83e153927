#pragma once

#include <memory>
#include <optional>
#include <string>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

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

}  // namespace surfit
