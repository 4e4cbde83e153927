#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/slam/slam.h"

namespace surfit {

// What a frame saw beside what the map shows from its pose after it. JPEG files.
struct KeptView {
  struct Picture {
    std::string name;  // input_color, model_color, input_depth or model_depth
    std::string jpeg;
  };
  int index = 0;  // of the frame
  double stamp_s = 0;
  std::string why;                // it was kept: "evenly spread, largest RMSE of registration"
  std::vector<Picture> pictures;  // those of colour only where the frame has colour
};

// Keeps the views of a few frames of a run whose length nobody knows. Evenly spread: of every
// stride-th frame, and whenever there are too many, every other is dropped and the stride doubled,
// so that 5 to 10 remain of 5 frames or more. And those where something happened: the first that
// was lost (seen from the pose before), the first with free directions, the one of largest RMSE,
// the last.
class KeptViews {
 public:
  static constexpr int kMost = 14;

  // To be called with each frame, and the map after it.
  void Offer(const RgbdFrame& frame, const FrameReport& report, const SurfelMap& map,
             const DepthSensor& sensor);
  // The views in order of their frames, to be called after the last frame.
  std::vector<KeptView> Finish(const SurfelMap& map, const DepthSensor& sensor) const;

  // Where the pictures are to be, relative to the run's folder.
  static std::string FileName(int view, const std::string& picture);
  // All that may be written.
  static std::vector<std::string> FileNames();
  // Writes them. Throws InputError naming the file.
  static void Write(const std::vector<KeptView>& views, const std::string& folder);

 private:
  static constexpr int kMostEven = 10;
  struct Last {
    RgbdFrame frame;
    Rigid3d world_from_camera;
  };

  bool IsNextOfStride();

  std::vector<KeptView> evenly_spread_;
  int stride_ = 1;
  int offered_ = 0;
  std::optional<KeptView> first_lost_, first_degenerate_, worst_;
  double worst_rmse_m_ = 0;
  std::optional<Last> last_;  // that was not lost
};

}  // namespace surfit
