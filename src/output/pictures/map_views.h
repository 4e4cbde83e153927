#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "output/pictures/canvas.h"
#include "output/pictures/picture_view.h"
#include "output/pictures/pictures.h"
#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Picture of equal cells with captions, below a header with title and legend. Cells are numbered by
// rows from 0.
class PictureSheet {
 public:
  static constexpr int kCellWidth = 800, kCellHeight = 600;
  static constexpr int kHeaderHeight = 76, kCaptionHeight = 34, kGap = 8;
  // Rendered pixels per sheet pixel along each axis.
  static constexpr int kSupersampling = 2;
  static constexpr Rgb8 kPaper = {255, 255, 255}, kInk = {20, 20, 20};
  // background of cells, contrasts with white and black objects
  static constexpr Rgb8 kScene = {109, 120, 134};

  PictureSheet(int columns, int rows);

  // Fills a cell by area averaging. `finer` has kSupersampling times the size of the cell.
  void SetCell(int cell, const Image<Rgb8>& finer);
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

// Four views of the surfels with shown[id] != 0, each of width x height px: from above, oblique
// from above, and from behind two cameras. An empty path stands for a camera at the origin. Without
// `upright`, up is the mean normal of surfaces that are approximately horizontal for the cameras.
std::array<PictureView, 4> ChooseMapViews(const SurfelMap& map,
                                          const std::vector<std::uint8_t>& shown,
                                          const Trajectory& camera_path,
                                          const std::optional<UprightWorld>& upright, int width,
                                          int height);

// Index of the pose with the largest difference to the first pose: angle in rad plus distance /
// scene_depth_m. 0 for a path of at most one pose.
std::size_t MostDifferentPose(const Trajectory& camera_path, double scene_depth_m);

}  // namespace surfit
