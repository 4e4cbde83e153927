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
// directory. Each sheet has four views of the map: from above, oblique from above, and from behind
// two cameras. The two cameras are the first camera and the camera with the most different pose.
// The up direction is the mean upward (-y) axis of the cameras, refined by the normals of floors
// and tables. The world frame may have any orientation.
//
// Back faces are not drawn, so ceiling and near walls do not occlude the room. All surfels are in
// map_confidence. The other sheets only have surfels with confidence >= NoiseConfidence(). The
// colour of a normal n in the world frame is (1 + n) / 2: x red, y green, z blue.
//
// For an empty map, the pictures have the text "empty map". Throws InputError if writing fails.
void WriteMapPictures(const SurfelMap& map, const Trajectory& camera_path,
                      const std::string& directory);

// Confidence below which surfels are treated as noise: 3 (about three central observations), or a
// tenth of the 90 % quantile of the map if this is less. 0 for an empty map.
float NoiseConfidence(const SurfelMap& map);

// Writes a PNG of the camera path from above and from the side, in m along the world axes. Both
// axes of a view have the same scale. The vertical axis is the world axis nearest to the mean
// upward (-y) axis of the cameras. `ground_truth` may be empty. Otherwise, both paths must be
// aligned, and a chart shows the position error over time. Throws InputError if writing fails.
void WriteTrajectoryPicture(const Trajectory& estimate, const Trajectory& ground_truth,
                            const std::string& path);

// Writes a PNG of two point clouds, source in orange and target in blue, from the target camera and
// from an oblique direction. Points are in m in the target camera frame (x right, y down, z
// forward). If the target is not in front of this camera, the first view is along z from outside.
// Each pixel shows the nearest point, so coinciding surfaces show both colours. Throws InputError
// if writing fails.
void WriteTwoCloudPicture(const std::vector<Eigen::Vector3f>& source,
                          const std::vector<Eigen::Vector3f>& target, const std::string& path);

// Colouring of the model in a live picture.
enum class ModelColors { kNormals, kColor };

// Pictures of a run in progress, kWidth x kHeight px. Images are centred and keep their aspect
// ratio.
class LivePictures {
 public:
  static constexpr int kWidth = 480, kHeight = 360;

  // `sensor`: sensor of the frames.
  explicit LivePictures(const DepthSensor& sensor);
  ~LivePictures();
  LivePictures(const LivePictures&) = delete;
  LivePictures& operator=(const LivePictures&) = delete;

  // Colour image of the frame. Without colour: depth image, near pixels are bright.
  Image<Rgb8> OfFrame(const RgbdFrame& frame) const;
  // Rendering of the map at a pose. Normals are coloured as in WriteMapPictures().
  Image<Rgb8> OfModel(const SurfelMap& map, const Rigid3d& world_from_camera, ModelColors colors);
  // Picture for lost tracking, shown instead of the model: the image of the last tracked frame with
  // an alarm. Tells the camera operator where to return. `last_good` may be empty.
  Image<Rgb8> OfLost(const Image<Rgb8>& last_good) const;

 private:
  struct Tools;
  std::unique_ptr<Tools> tools_;
};

}  // namespace surfit
