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

// How a picture for a mesh is made of frames.
struct TextureOptions {
  int max_texture_px = 8192;     // along the picture's sides; 0 = no picture
  int max_texture_frames = 200;  // that are looked at, those that moved least; 0 = all
  double least_sharpness = 0.6;  // of a triangle's frame, as a share of that of its sharpest one
  double seam_cost = 0.3;        // of an edge between frames, as a share of sharpness

  void Visit(OptionVisitor& visitor);
};

// A frame with colours, and how its camera moved while it took them.
struct TextureFrame {
  RgbdFrame frame;
  PinholeCamera camera;  // of its pixels
  Rigid3d world_from_camera;
  CameraMotion motion;
  double readout_s = 0;  // of the rows
};

// Calls its argument with frames, one after the other, the same ones each time.
using TextureFrames = std::function<void(const std::function<void(const TextureFrame&)>&)>;

// A picture for a mesh. Corners of triangles that are one place of the mesh may be several places
// of the picture.
struct MeshTexture {
  std::vector<std::uint32_t> vertices;  // of the mesh, one for each place
  std::vector<Eigen::Vector2f> places;  // shares of width and height, from the upper left corner
  std::vector<TriangleMesh::Triangle> triangles;  // the mesh's in their order, of places
  Image<Rgb8> image;
};

// What was made of frames.
struct TextureSummary {
  int frames = 0, frames_shown = 0;  // looked at, and those that the picture shows
  std::size_t charts = 0;            // pieces of the picture
  std::size_t triangles_unseen = 0;  // that no frame shows: they have their vertices' colours
  double pixel_share = 1;            // texels for a pixel of a frame, along a side
};

// Makes a picture for a mesh with normals and colours from the frames that show it sharpest (as
// Lempitsky and Ivanov, "Seamless mosaicing of image-based texture maps", 2007). A frame shows a
// triangle that faces it and that no other part of the mesh, nor what the frame has measured,
// hides; it shows it the sharper, the finer and the less slanted its pixels are there and the less
// motion blurs them, as in FrameColors. Frames that show most of the mesh nearly as sharply as any
// are taken first, so that there are few seams, and brightened to fit the mesh's own colours. The
// result does not depend on the number of threads; one frame is in memory at a time. Throws
// InputError if the options are not valid or the picture is too small for so many pieces.
MeshTexture TextureMesh(const TriangleMesh& mesh, const TextureFrames& frames,
                        const TextureOptions& options, TextureSummary* summary);

// Writes the mesh with its picture, by the ending of the path:
//   .obj  with a .mtl and a .jpg of the same name beside it;
//   .glb  with the picture in it.
// Throws InputError as WriteMesh() does, and for .ply, which has no pictures.
void WriteMesh(const TriangleMesh& mesh, const MeshTexture& texture, const std::string& path);

// Throws InputError unless the path has one of these endings.
void RequireTextureEnding(const std::string& path);

}  // namespace surfit
