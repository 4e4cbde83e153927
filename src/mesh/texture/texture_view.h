#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/texture/texture_camera.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// What a frame shows of a mesh.
class TextureView {
 public:
  TextureView(const TriangleMesh& mesh, const TextureFrame& frame);

  const TextureCamera& camera() const { return camera_; }
  // How sharply it shows each triangle, as FrameColors weighs colours; 0 where it does not.
  const std::vector<float>& sharpness() const { return sharpness_; }
  // What the colours of frames, red, green and blue, are to be multiplied by to be those of the
  // mesh.
  Eigen::Vector3f gain() const { return gain_; }

 private:
  using Triangle = TriangleMesh::Triangle;

  void DrawDepths();
  void FindClearPixels();
  float SharpnessOf(const Triangle& triangle) const;
  // Whether nothing hides it, what the frame measured is there, and colours are all around.
  bool IsClear(const Triangle& triangle) const;
  bool IsClearAt(float u, float v, float z) const;
  Rgb8 ColorOf(std::uint32_t vertex) const;  // that is seen clearly
  void FindGain();

  const TriangleMesh& mesh_;
  const TextureFrame& frame_;
  const TextureCamera camera_;
  std::vector<TextureCamera::Place> places_;  // of the mesh's vertices
  Image<float> nearest_m_;                    // depth of the mesh in and around each pixel
  Image<std::uint8_t> is_clear_;              // no border, and nothing without colour, is near
  std::vector<float> sharpness_;
  Eigen::Vector3f gain_ = Eigen::Vector3f::Ones();
};

}  // namespace surfit
