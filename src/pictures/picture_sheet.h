#pragma once

#include <string>

#include "pictures/canvas.h"
#include "surfit/core/image.h"

namespace surfit {

// A picture of equal cells, each above a caption, in rows below a header for title and legend.
class PictureSheet {
 public:
  static constexpr int kCellWidth = 800, kCellHeight = 600;
  static constexpr int kHeaderHeight = 76, kCaptionHeight = 34, kGap = 8;
  // Cells are drawn in this many pixels per pixel of the sheet, in each direction.
  static constexpr int kSupersampling = 2;
  static constexpr Rgb8 kPaper = {255, 255, 255}, kInk = {20, 20, 20};

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

}  // namespace surfit
