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
  // Maximum width and height of the texture, px; at most 16384. 0 means no texture, which the
  // caller must handle: TextureMesh() throws InputError for 0.
  int max_texture_px = 8192;
  // Maximum number of frames; 0: all. TextureMesh() ignores it: the caller selects the frames.
  int max_texture_frames = 200;
  // Minimum sharpness of the frame of a triangle, relative to its sharpest frame.
  double min_sharpness = 0.6;
  // Cost of a seam edge between triangles of different frames, in units of relative sharpness.
  double seam_cost = 0.3;

  void Visit(OptionVisitor& visitor);
};

// Frame with colours, pose and camera motion, for a texture. Depth and colour have the size of
// `camera`.
struct TextureFrame {
  RgbdFrame frame;
  PinholeCamera camera;  // of depth and colour, without distortion
  Rigid3d world_from_camera;
  CameraMotion motion;
  double readout_s = 0;  // rolling-shutter readout
};

// Calls its argument with each frame. Must supply the same frames in the same order at every call.
// A frame is used only during the call of the argument.
using TextureFrames = std::function<void(const std::function<void(const TextureFrame&)>&)>;

// Texture of a mesh. Vertices at seams have several texture coordinates.
struct MeshTexture {
  std::vector<std::uint32_t> vertices;               // mesh vertex of each texture coordinate
  std::vector<Eigen::Vector2f> texture_coordinates;  // in [0, 1], from the upper left corner
  // mesh triangles in their order, as indices of texture coordinates
  std::vector<TriangleMesh::Triangle> triangles;
  Image<Rgb8> image;
};

// Statistics of TextureMesh().
struct TextureSummary {
  int frames = 0, frames_used = 0;   // input frames; frames in the texture
  std::size_t charts = 0;            // connected regions of the texture
  std::size_t triangles_unseen = 0;  // visible in no frame: have vertex colours
  double pixel_ratio = 1;            // texels per frame pixel along an axis
};

// Computes a texture for a mesh with normals and colours (as Lempitsky and Ivanov, "Seamless
// mosaicing of image-based texture maps", 2007). Each triangle has the texture of one sharp frame:
// - A triangle is visible in a frame if it faces the camera and is not occluded. The mesh and the
//   measured depth can occlude it.
// - Sharpness increases with image resolution and decreases with slant and motion blur, as in
//   FrameColors.
// - Few frames are selected, so that there are few seams.
// - Frames are adapted to the brightness of the vertex colours.
//
// Calls `frames` twice, and keeps one frame in memory at a time. Without frames, the texture has
// the vertex colours. `summary` must not be null. The result does not depend on the number of
// threads. Throws InputError for invalid options, and if the texture is too small for its regions.
// Throws unless the mesh has one normal and one colour per vertex.
MeshTexture TextureMesh(const TriangleMesh& mesh, const TextureFrames& frames,
                        const TextureOptions& options, TextureSummary* summary);

// Writes the mesh with its texture, by the extension of the path:
//   .obj  with a .mtl and a .jpg of the same name in the same folder
//   .glb  with the texture in the file
// Replaces existing files. Throws InputError for other extensions, if a file cannot be written, and
// for a .glb without triangles.
void WriteMesh(const TriangleMesh& mesh, const MeshTexture& texture, const std::string& path);

// Throws InputError unless the extension of the path is .obj or .glb.
void RequireTextureEnding(const std::string& path);

}  // namespace surfit
