#pragma once

#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// What a frame saw beside what the map, with that frame fused, shows from its pose. JPEG files.
struct KeptView {
  struct Picture {
    std::string name;  // input_color, model_color, input_depth or model_depth
    std::string jpeg;
  };
  int index = 0;  // of the frame
  double stamp_s = 0;
  std::vector<Picture> pictures;  // those of colour only where the frame has colour
};

// Keeps the views of a few frames, evenly spread, of a run whose length nobody knows: of every
// stride-th frame, and whenever there are too many, every other is dropped and the stride doubled.
// From 5 to 10 views remain of a run of 5 frames or more.
class KeptViews {
 public:
  static constexpr int kMost = 10;

  // To be called with each frame that was fused, and the map after it.
  void Offer(const RgbdFrame& frame, const SurfelMap& map, const PinholeCamera& camera,
             const Rigid3d& world_from_camera);
  const std::vector<KeptView>& views() const { return views_; }

  // Where the pictures are to be, relative to the run's folder.
  static std::string FileName(int view, const std::string& picture);
  // All that may be written.
  static std::vector<std::string> FileNames();
  // Writes them. Throws InputError naming the file.
  void Write(const std::string& folder) const;

 private:
  std::vector<KeptView> views_;
  int stride_ = 1;
  int offered_ = 0;
};

}  // namespace surfit
