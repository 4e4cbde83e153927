#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/texture/texture_camera.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// Visibility and sharpness of a mesh in a frame with colour.
class TextureView {
 public:
  // Computes all results. The mesh needs normals and colours. Keeps references to the arguments.
  TextureView(const TriangleMesh& mesh, const TextureFrame& frame);

  const TextureCamera& camera() const { return camera_; }
  // Sharpness per triangle: the colour weight of FrameColors, reduced for overexposed colours. 0:
  // not visible. A visible triangle is not occluded, agrees with the measured depth, and has
  // colours everywhere.
  const std::vector<float>& sharpness() const { return sharpness_; }
  // Gains per channel from frame colours to mesh colours, 0.5 to 2. 1 if fewer than 100 triangles
  // give a gain.
  Eigen::Vector3f gain() const { return gain_; }

 private:
  using Triangle = TriangleMesh::Triangle;

  void DrawDepths();
  void FindClearPixels();
  float SharpnessOf(const Triangle& triangle) const;
  // True if the triangle is not occluded, agrees with the measured depth, and has colours
  // everywhere.
  bool IsClear(const Triangle& triangle) const;
  bool IsClearAt(float u, float v, float z) const;
  Rgb8 ColorOf(std::uint32_t vertex) const;  // requires a visible vertex
  void FindGain();

  const TriangleMesh& mesh_;
  const TextureFrame& frame_;
  const TextureCamera camera_;
  std::vector<TextureCamera::Place> places_;
  Image<float> nearest_m_;        // smallest mesh depth around each pixel; infinity: none
  Image<std::uint8_t> is_clear_;  // 0 near image borders and missing colours
  std::vector<float> sharpness_;
  Eigen::Vector3f gain_ = Eigen::Vector3f::Ones();
};

}  // namespace surfit
