#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Confidence below which surfels are noise: 3 (about three central observations), or less for a map
// of low confidence. Then it is a tenth of the 90 % quantile. 0 for an empty map.
float NoiseConfidence(const SurfelMap& map);
// Surfels with confidence >= NoiseConfidence() and a finite position, in the order of
// SurfelMap::Ids().
std::vector<Surfel> ReliableSurfels(const SurfelMap& map);

// Upright world frame: z is up.
struct UprightWorld {
  Rigid3d upright_from_world;
  double sigma_rad = 0;                  // standard deviation of the direction of gravity
  int horizontal_planes = 0, walls = 0;  // used for the direction of gravity
  double horizontal_area_m2 = 0;
  double floor_area_m2 = 0;      // area of the plane at z = 0
  bool walls_give_axes = false;  // false: x is the projection of an axis of the run
};

// Result of FindUpright(). Without a world, `reason` has the missing evidence.
struct UprightResult {
  std::optional<UprightWorld> world;
  std::string reason;
};

// Finds the direction of gravity from horizontal planes and walls of a map.
//
// The mean upward (-y) axis of the cameras is the first estimate. It can be wrong by 45 degrees.
// The normals of surfels narrow it to the dominant direction. Then planes are fitted: horizontal
// planes that face up or down, and walls. With the unit normal n_i of a plane and the inertia a_i
// of its points along the plane, the direction g minimises
//   sum over horizontal planes of a_i |n_i x g|^2 + sum over walls of a_j (n_j . g)^2.
// The standard deviation is computed from the scatter of the planes, and is at least 0.1 degrees.
//
// The floor is the lowest large plane that faces up, below most cameras. It is at z = 0. The x and
// y axes are along the walls, with the smallest rotation about z from the axes of the run. The
// world origin of the run stays on the z axis.
//
// Gives no world if the cameras have no common upward direction, or if the standard deviation is
// above 1 degree. At least 0.3 m2 of horizontal planes are necessary. `surfels` must be free of
// noise: ReliableSurfels().
UprightResult FindUpright(const std::vector<Surfel>& surfels, const Trajectory& cameras);

// Writes map_color.png, map_normals.png, map_confidence.png and map_last_seen.png into the
// directory. Each picture has four views: from above, oblique from above, and from behind two
// cameras. The cameras have the first pose and the most different pose. Without `upright`, the up
// direction is only estimated from the cameras and the normals of horizontal surfaces.
//
// Back faces are not drawn, so ceiling and near walls do not occlude the room. map_confidence shows
// all surfels. The other pictures show surfels with confidence >= NoiseConfidence(). A normal n in
// the world frame has the colour (1 + n) / 2: x red, y green, z blue. Without colour images,
// map_color.png shows grey surfels, shaded by their normals.
//
// An empty map gives pictures with the text "empty map". Throws InputError if writing fails.
void WriteMapPictures(const SurfelMap& map, const Trajectory& camera_path,
                      const std::string& directory,
                      const std::optional<UprightWorld>& upright = std::nullopt);

// Writes a PNG of the camera path from above and from the side, in m, with equal scales of both
// axes. The vertical axis is the world axis nearest to the mean upward (-y) axis of the cameras.
// With `ground_truth`, both paths are drawn and must be aligned, and a chart shows the position
// error over time. Without poses at common times: no chart. Throws InputError if writing fails.
void WriteTrajectoryPicture(const Trajectory& estimate, const Trajectory& ground_truth,
                            const std::string& path);

// Writes a PNG of two point clouds from two directions: source in orange, target in blue. Points
// are in the target camera frame (x right, y down, z forward), m. One view is from the target
// camera, the second view is oblique. If more than 1 % of the target is behind the camera, the
// first view looks along z from a point in front of the target. Throws InputError if writing fails.
void WriteTwoCloudPicture(const std::vector<Eigen::Vector3f>& source,
                          const std::vector<Eigen::Vector3f>& target, const std::string& path);

// Colouring of the rendered map.
enum class ModelColors { kNormals, kColor };

// Pictures of a run in progress, kWidth x kHeight px. Images keep their aspect ratio. Not
// thread-safe.
class LivePictures {
 public:
  static constexpr int kWidth = 480, kHeight = 360;

  // `sensor`: camera of the frames. Larger images are rendered at reduced resolution.
  explicit LivePictures(const DepthSensor& sensor);
  ~LivePictures();
  LivePictures(const LivePictures&) = delete;
  LivePictures& operator=(const LivePictures&) = delete;

  // Colour image of the frame. Without colour: depth image, near pixels are bright.
  Image<Rgb8> OfFrame(const RgbdFrame& frame) const;
  // Map rendered at a pose. Normals are coloured as in WriteMapPictures().
  Image<Rgb8> OfModel(const SurfelMap& map, const Rigid3d& world_from_camera, ModelColors colors);
  // Picture for lost tracking: the image of the last tracked frame with an alarm, so that the
  // operator can return there. `last_good` may be empty.
  Image<Rgb8> OfLost(const Image<Rgb8>& last_good) const;

 private:
  struct Tools;
  std::unique_ptr<Tools> tools_;
};

}  // namespace surfit
