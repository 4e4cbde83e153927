#pragma once

#include <memory>
#include <string>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

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
  // The map from behind and above the first camera, the way the cameras went in orange and the last
  // of them in red, before all surfaces. A large map is thinned evenly, surfels that face away are
  // not drawn.
  void ShowMap(const SurfelMap& map, const Trajectory& camera_path);
  // Two lines of text.
  void ShowText(const std::string& first, const std::string& second);

  // kWidth x kHeight pixels.
  const Image<Rgb8>& image() const { return image_; }

 private:
  struct Tools;
  std::unique_ptr<Tools> tools_;
  Image<Rgb8> image_;
};

}  // namespace surfit
