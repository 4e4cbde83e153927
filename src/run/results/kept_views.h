#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "run/results/even_sample.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Frame of a run with JPEG pictures of the frame and of the map.
struct KeptView {
  // `name`: input_color, model_color, input_depth or model_depth. `jpeg`: content of the file.
  struct Picture {
    std::string name;
    std::string jpeg;
  };
  int index = 0;
  double stamp_s = 0;
  std::string why;                // reasons of selection, separated by ", "
  std::vector<Picture> pictures;  // depth pictures only, if the frame has no colour
};

// Keeps the views of a few frames of a run of unknown length:
//   5 to 10 evenly spaced frames with a pose (EvenSample),
//   the first lost frame, with the model view at the last pose before it,
//   the first degenerate frame,
//   the frame with the largest registration RMSE,
//   the last frame with a pose.
class KeptViews {
 public:
  static constexpr int kMost = 14;

  // Call with each frame. `map`: map after this frame. Renders the map only for kept frames.
  // `sensor`: current camera. Frames without a pose before the first pose are not kept.
  void Offer(const RgbdFrame& frame, const FrameReport& report, const SurfelMap& map,
             const DepthSensor& sensor);
  // Returns the views by frame. Call after the last frame, whose model view is rendered.
  std::vector<KeptView> Finish(const SurfelMap& map, const DepthSensor& sensor) const;

  // File name in the output folder, and all names that Write() can use. `view`: position in the
  // list.
  static std::string FileName(int view, const std::string& picture);
  static std::vector<std::string> FileNames();
  // Writes the pictures into the output folder. Throws InputError with the path.
  static void Write(const std::vector<KeptView>& views, const std::string& folder);

 private:
  struct Last {
    RgbdFrame frame;
    Rigid3d world_from_camera;
  };

  EvenSample<KeptView> evenly_spread_{10};
  std::optional<KeptView> first_lost_, first_degenerate_, worst_;
  double worst_rmse_m_ = 0;
  std::optional<Last> last_;
};

// Keeps thumbnails of 60 to 120 evenly spaced frames (EvenSample). Frames with a pose also get a
// view of the final map. KeptView::why is empty.
class Thumbnails {
 public:
  static constexpr int kMost = 120;
  static constexpr int kWidth_px = 320;  // approximate size: images are reduced by integer factors

  // Call with each frame, including lost frames.
  void Offer(const RgbdFrame& frame);
  // Returns the thumbnails by frame. `world_from_camera`: poses by frame index.
  std::vector<KeptView> Finish(const SurfelMap& map, const DepthSensor& sensor,
                               const std::map<int, Rigid3d>& world_from_camera) const;

  // As in KeptViews.
  static std::string FileName(int thumbnail, const std::string& picture);
  static std::vector<std::string> FileNames();
  static void Write(const std::vector<KeptView>& thumbnails, const std::string& folder);

 private:
  struct Kept {
    int index = 0;
    double stamp_s = 0;
    Image<Rgb8> color;
    Image<float> depth_m;  // only without colour
  };

  EvenSample<Kept> kept_{kMost};
};

}  // namespace surfit
