#include "output/pictures/map_views.h"

namespace surfit {

PictureSheet::PictureSheet(int columns, int rows)
    : columns_(columns),
      image_(columns * kCellWidth + (columns - 1) * kGap,
             kHeaderHeight + rows * (kCellHeight + kCaptionHeight), kPaper) {}

PictureSheet::Corner PictureSheet::CellCorner(int cell) const {
  return {(cell % columns_) * (kCellWidth + kGap),
          kHeaderHeight + (cell / columns_) * (kCellHeight + kCaptionHeight)};
}

void PictureSheet::SetCell(int cell, const Image<Rgb8>& finer) {
  const auto [left, top] = CellCorner(cell);
  DrawImage(&image_, {left, top, kCellWidth, kCellHeight}, finer);
}

void PictureSheet::DrawCaption(int cell, const std::string& text) {
  const auto [left, top] = CellCorner(cell);
  DrawText(&image_, {left + kCellWidth / 2., top + kCellHeight + kCaptionHeight / 2.}, text,
           {18, 0.5, kInk});
}

}  // namespace surfit
