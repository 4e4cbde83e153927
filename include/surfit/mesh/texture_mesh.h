#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

class OptionVisitor;

// Options of TextureMesh().
struct TextureOptions {
  // Maximum width and height of the texture, px. 0: no texture, for callers that then do not call
  // TextureMesh().
  int max_texture_px = 8192;
  // Maximum number of frames; 0: all. TextureMesh() ignores it. The supplier of the frames uses it:
  // surfit_mesh selects the slowest frame in equal parts of the run.
  int max_texture_frames = 200;
  // Minimum sharpness of the frame of a triangle, relative to the sharpest frame of the triangle.
  double min_sharpness = 0.6;
  // Cost of an edge between triangles of different frames, in units of relative sharpness.
  double seam_cost = 0.3;

  void Visit(OptionVisitor& visitor);
};

// Colour frame for a texture, with its camera motion.
struct TextureFrame {
  RgbdFrame frame;
  PinholeCamera camera;  // camera of the depth and colour pixels
  Rigid3d world_from_camera;
  CameraMotion motion;
  double readout_s = 0;  // rolling-shutter readout
};

// Calls its argument with each frame, one at a time. Each call of TextureFrames must supply the
// same frames in the same order.
using TextureFrames = std::function<void(const std::function<void(const TextureFrame&)>&)>;

// Texture of a mesh. A mesh vertex at a seam has several texture coordinates.
struct MeshTexture {
  std::vector<std::uint32_t> vertices;  // index of the mesh vertex, per texture coordinate
  std::vector<Eigen::Vector2f> places;  // in [0, 1] of width and height, from the upper left corner
  // triangles of the mesh in their order, as indices of texture coordinates
  std::vector<TriangleMesh::Triangle> triangles;
  Image<Rgb8> image;
};

// Statistics of TextureMesh().
struct TextureSummary {
  int frames = 0, frames_used = 0;   // candidate frames, and frames in the texture
  std::size_t charts = 0;            // connected regions of the texture
  std::size_t triangles_unseen = 0;  // visible in no frame: textured by vertex colours
  double pixel_ratio = 1;            // texels per frame pixel, along one axis
};

// Computes a texture for a mesh with normals and colours (as Lempitsky and Ivanov, "Seamless
// mosaicing of image-based texture maps", 2007). Each triangle takes its texture from a frame that
// sees it sharply:
// - A triangle is visible in a frame if it faces the camera and is not occluded. The mesh and the
//   measured depth can occlude it.
// - Sharpness increases with image resolution and decreases with slant and motion blur, as in
//   FrameColors.
// - Frames that see most of the mesh nearly as sharply as any other frame are selected first, so
//   that there are few seams.
// - Frames are adapted to the brightness of the vertex colours.
//
// Calls `frames` twice and keeps one frame in memory at a time. The result does not depend on the
// number of threads. Throws InputError for invalid options, if `max_texture_px` is 0, and if the
// texture is too small for the number of its regions. Aborts if the mesh lacks a normal or a colour
// per vertex.
MeshTexture TextureMesh(const TriangleMesh& mesh, const TextureFrames& frames,
                        const TextureOptions& options, TextureSummary* summary);

// Writes the mesh with its texture, by the extension of the path:
//   .obj  with a .mtl and a .jpg of the same name in the same folder
//   .glb  with the texture in the file
// Throws InputError for other extensions, and if a file cannot be written.
void WriteMesh(const TriangleMesh& mesh, const MeshTexture& texture, const std::string& path);

// Throws InputError unless the extension of the path is .obj or .glb.
void RequireTextureEnding(const std::string& path);

}  // namespace surfit
