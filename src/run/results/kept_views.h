#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "run/results/even_share.h"
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

// Keeps the views of a few frames of a run whose length nobody knows. Evenly spread (EvenShare): 5
// to 10 of 5 frames or more. And those where something happened: the first that was lost (seen from
// the pose before), the first with free directions, the one of largest RMSE, the last.
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
  struct Last {
    RgbdFrame frame;
    Rigid3d world_from_camera;
  };

  EvenShare<KeptView> evenly_spread_{10};
  std::optional<KeptView> first_lost_, first_degenerate_, worst_;
  double worst_rmse_m_ = 0;
  std::optional<Last> last_;  // that was not lost
};

// Keeps small pictures of frames, 60 to 120 of 60 or more (EvenShare): what a frame saw and, where
// it has a pose, the map in the end from there. KeptView::why stays empty.
class Thumbnails {
 public:
  static constexpr int kMost = 120;
  static constexpr int kWidth_px = 320;  // about: frames are made smaller by whole factors

  // To be called with each frame, lost ones, too.
  void Offer(const RgbdFrame& frame);
  // In order of their frames, with the poses by the frames' indices.
  std::vector<KeptView> Finish(const SurfelMap& map, const DepthSensor& sensor,
                               const std::map<int, Rigid3d>& world_from_camera) const;

  // As those of KeptViews.
  static std::string FileName(int thumbnail, const std::string& picture);
  static std::vector<std::string> FileNames();
  static void Write(const std::vector<KeptView>& thumbnails, const std::string& folder);

 private:
  struct Kept {
    int index = 0;
    double stamp_s = 0;
    Image<Rgb8> color;  // or none, and
    Image<float> depth_m;
  };

  EvenShare<Kept> kept_{kMost};
};

}  // namespace surfit
