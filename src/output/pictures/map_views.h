#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "output/pictures/canvas.h"
#include "output/pictures/picture_view.h"
#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// A picture of equal cells, each above a caption, in rows below a header for title and legend.
class PictureSheet {
 public:
  static constexpr int kCellWidth = 800, kCellHeight = 600;
  static constexpr int kHeaderHeight = 76, kCaptionHeight = 34, kGap = 8;
  // Cells are drawn in this many pixels per pixel of the sheet, in each direction.
  static constexpr int kSupersampling = 2;
  static constexpr Rgb8 kPaper = {255, 255, 255}, kInk = {20, 20, 20};
  // Behind what a cell shows: neither white nor black things are lost before it.
  static constexpr Rgb8 kScene = {109, 120, 134};

  PictureSheet(int columns, int rows);

  // Fills the cell from an image of kSupersampling times its size, by averaging.
  void SetCell(int cell, const Image<Rgb8>& finer);
  // Writes below the cell.
  void DrawCaption(int cell, const std::string& text);

  Image<Rgb8>* image() { return &image_; }

 private:
  struct Corner {
    int left, top;
  };
  Corner CellCorner(int cell) const;

  int columns_;
  Image<Rgb8> image_;
};

// Four views of the surfels with shown[id] != 0, each width x height pixels: from above, from a
// bird's place, from the first camera pulled back, and from the camera that looks most elsewhere.
std::array<PictureView, 4> ChooseMapViews(const SurfelMap& map,
                                          const std::vector<std::uint8_t>& shown,
                                          const Trajectory& camera_path, int width, int height);

// The pose of the path whose view differs most from the first's: by the angle in rad plus the
// distance in units of scene_depth_m. 0 for a path of one pose.
std::size_t MostDifferentPose(const Trajectory& camera_path, double scene_depth_m);

}  // namespace surfit
