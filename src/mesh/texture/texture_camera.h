#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// Projects world points into the colour image of a frame. Corrects the motion as FrameColors does:
// projects X - t (turn x X + velocity) for a row with capture time t. X is in the camera frame at
// RgbdFrame::stamp_s, which is the time of the pose. t is relative to this time.
class TextureCamera {
 public:
  // Pixel, depth in m, and image motion in px/s. z = 0: behind the camera, or less than 0.05 m in
  // front of it.
  struct Place {
    float u = 0, v = 0, z = 0, speed = 0;
  };

  // Copies all values. Requires a frame with colour.
  explicit TextureCamera(const TextureFrame& frame)
      : rotation_(frame.world_from_camera.Inverse().rotation.toRotationMatrix().cast<float>()),
        translation_(frame.world_from_camera.Inverse().translation.cast<float>()),
        center_(frame.world_from_camera.translation.cast<float>()),
        turn_(frame.motion.angular_velocity_rad_per_s.cast<float>()),
        velocity_(frame.motion.velocity_m_per_s.cast<float>()),
        fx_(static_cast<float>(frame.camera.fx)),
        fy_(static_cast<float>(frame.camera.fy)),
        cx_(static_cast<float>(frame.camera.cx)),
        cy_(static_cast<float>(frame.camera.cy)),
        middle_v_(0.5f * static_cast<float>(frame.camera.height) - 0.5f),
        middle_s_(static_cast<float>(frame.frame.color_stamp_s - frame.frame.stamp_s)),
        row_s_(static_cast<float>(frame.readout_s / frame.camera.height)) {}

  float fx() const { return fx_; }
  const Eigen::Vector3f& center() const { return center_; }

  // Projects a point. It can be outside of the image.
  Place See(const Eigen::Vector3f& point_in_world) const {
    constexpr float kLeastDepth = 0.05f;  // metres
    const Eigen::Vector3f x = rotation_ * point_in_world + translation_;
    if (!(x.z() > kLeastDepth)) return {};
    const Eigen::Vector3f way = turn_.cross(x) + velocity_;
    const float rho = 1 / x.z(), u = fx_ * x.x() * rho + cx_, v = fy_ * x.y() * rho + cy_;
    const float u_per_s = -fx_ * rho * (way.x() - x.x() * rho * way.z());
    const float v_per_s = -fy_ * rho * (way.y() - x.y() * rho * way.z());
    // Solves t = middle + (v + v_per_s t - middle_v) row.
    const float t = (middle_s_ + (v - middle_v_) * row_s_) / std::max(0.5f, 1 - v_per_s * row_s_);
    return {u + u_per_s * t, v + v_per_s * t, std::max(kLeastDepth, x.z() - way.z() * t),
            std::sqrt(u_per_s * u_per_s + v_per_s * v_per_s)};
  }

 private:
  Eigen::Matrix3f rotation_;  // camera from world
  Eigen::Vector3f translation_, center_;
  Eigen::Vector3f turn_, velocity_;
  float fx_, fy_, cx_, cy_, middle_v_, middle_s_, row_s_;
};

}  // namespace surfit
