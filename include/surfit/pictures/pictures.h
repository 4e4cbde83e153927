#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Writes map_color.png, map_normals.png, map_confidence.png and map_last_seen.png into the
// directory. Each is a sheet of four views of the map: from above, from an oblique bird's eye, from
// the first camera pulled back a little, and from the camera whose view differs most from the
// first. Up is the mean of the cameras' upward (-y) axes, refined by the normals of floors and
// tables, so any world frame will do.
//
// Surfels that face away are not drawn, which opens the ceiling and the near walls. map_confidence
// shows all surfels, the other sheets only those of confidence >= DustConfidence(). Normals are
// coloured (1 + n) / 2 for n in the world frame: x red, y green, z blue.
//
// An empty map gives pictures that say so. Throws InputError where a file cannot be written.
void WriteMapPictures(const SurfelMap& map, const Trajectory& camera_path,
                      const std::string& directory);

// Below this confidence a surfel is taken for dust: 3 (about as many central observations), or a
// tenth of the map's 90 % quantile where that is less, as after few frames. 0 for an empty map.
float DustConfidence(const SurfelMap& map);

// Writes a PNG of the camera's path from above and from the side, in metres along the world's axes,
// with equal scale on both axes of a view. ground_truth may be empty; where it is not, the caller
// has aligned the two. The vertical axis is the world axis nearest to the cameras' mean upward (-y)
// axis. Throws InputError where the file cannot be written.
void WriteTrajectoryPicture(const Trajectory& estimate, const Trajectory& ground_truth,
                            const std::string& path);

// Writes a PNG of two point clouds, source in orange and target in blue, seen from the target's
// camera and obliquely from the side. Points are in metres in the target camera's frame (x right, y
// down, z forward); a target that is not in front of that camera is seen along z from far enough
// away. Each pixel shows the nearest point: surfaces that coincide show both colours mixed. Throws
// InputError where the file cannot be written.
void WriteTwoCloudPicture(const std::vector<Eigen::Vector3f>& source,
                          const std::vector<Eigen::Vector3f>& target, const std::string& path);

// From where a map is looked at, beside the view of all of it.
struct MapOrbit {
  double right_rad = 0, up_rad = 0;                   // that the eye goes around what it looks at
  double distance = 1;                                // times that of the view of all
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  // in the world
  bool follows = false;                               // the last camera, from nearer by
};

// Where two cameras were that a loop joins, in the world.
struct LoopSegment {
  Eigen::Vector3d a, b;
};

// What the model's tile shows of the surfels that a camera sees.
enum class ModelColors { kNormals, kColor };

// A picture of a run in progress, in tiles that are drawn one by one: the frame, the model as the
// frame's camera sees it, the map with the camera's path, and lines of text between.
class LivePicture {
 public:
  static constexpr int kTileWidth = 480, kTileHeight = 360;  // of frame and model
  static constexpr int kTextHeight = 56;
  static constexpr int kMapHeight = 440;  // the map is two tiles wide
  static constexpr int kWidth = 2 * kTileWidth;
  static constexpr int kHeight = kTileHeight + kTextHeight + kMapHeight;

  // The sensor of the frames.
  explicit LivePicture(const DepthSensor& sensor);
  ~LivePicture();
  LivePicture(const LivePicture&) = delete;
  LivePicture& operator=(const LivePicture&) = delete;

  // The frame's colours; where it has none, the nearer the brighter.
  void ShowFrame(const RgbdFrame& frame);
  // The map as predicted from a pose. Normals are coloured as in WriteMapPictures().
  void ShowModel(const SurfelMap& map, const Rigid3d& world_from_camera, ModelColors colors);
  // In place of the model: that tracking is lost, and the last image whose pose was known, for who
  // holds the camera to go back to. Nothing but the words where there is none.
  void ShowLost(const Image<Rgb8>& last_good);
  // The map from behind and above the first camera, or as orbit() says; the way the cameras went in
  // orange, the last of them in red and loops in green, before all surfaces. Drawn as DrawBlended()
  // does; coarsely, with a quarter of the pixels, where it is to be quick.
  void ShowMap(const SurfelMap& map, const Trajectory& camera_path,
               const std::vector<LoopSegment>& loops = {}, bool coarsely = false);
  // Two lines of text.
  void ShowText(const std::string& first, const std::string& second);

  const MapOrbit& orbit() const { return orbit_; }
  void SetOrbit(const MapOrbit& orbit) { orbit_ = orbit; }
  // Moves the map by so many pixels to the right and down, as far as its middle goes.
  void DragMap(double right_px, double down_px);
  // Whether a pixel is the map's.
  static bool IsInMap(int u, int v) { return v >= kTileHeight + kTextHeight && u < kWidth; }

  // kWidth x kHeight pixels.
  const Image<Rgb8>& image() const { return image_; }

 private:
  struct Tools;
  std::unique_ptr<Tools> tools_;
  Image<Rgb8> image_;
  MapOrbit orbit_;
};

}  // namespace surfit
