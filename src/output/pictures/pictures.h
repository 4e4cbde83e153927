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
// with equal scale on both axes of a view. The vertical axis is the world axis nearest to the mean
// upward (-y) axis of the cameras. ground_truth may be empty. Otherwise the caller has aligned both
// paths, and a panel shows the position error over time at the poses with a true pose. Throws
// InputError if the file cannot be written.
void WriteTrajectoryPicture(const Trajectory& estimate, const Trajectory& ground_truth,
                            const std::string& path);

// Writes a PNG of two point clouds, source in orange and target in blue, seen from the target's
// camera and obliquely from the side. Points are in metres in the target camera's frame (x right, y
// down, z forward); a target that is not in front of that camera is seen along z from far enough
// away. Each pixel shows the nearest point: surfaces that coincide show both colours mixed. Throws
// InputError where the file cannot be written.
void WriteTwoCloudPicture(const std::vector<Eigen::Vector3f>& source,
                          const std::vector<Eigen::Vector3f>& target, const std::string& path);

// What a picture of the map shows of the surfels that a camera sees.
enum class ModelColors { kNormals, kColor };

// Pictures of a run in progress, kWidth x kHeight pixels each. What they show keeps its proportions
// and stands in the middle.
class LivePictures {
 public:
  static constexpr int kWidth = 480, kHeight = 360;

  // The sensor of the frames.
  explicit LivePictures(const DepthSensor& sensor);
  ~LivePictures();
  LivePictures(const LivePictures&) = delete;
  LivePictures& operator=(const LivePictures&) = delete;

  // The frame's colours; where it has none, the nearer the brighter.
  Image<Rgb8> OfFrame(const RgbdFrame& frame) const;
  // The map as predicted from a pose. Normals are coloured as in WriteMapPictures().
  Image<Rgb8> OfModel(const SurfelMap& map, const Rigid3d& world_from_camera, ModelColors colors);
  // In place of the model: that tracking is lost, and the last image whose pose was known, for who
  // holds the camera to go back to. Nothing but the words where there is none.
  Image<Rgb8> OfLost(const Image<Rgb8>& last_good) const;

 private:
  struct Tools;
  std::unique_ptr<Tools> tools_;
};

}  // namespace surfit
