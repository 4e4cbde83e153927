#include <cstdint>

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
  constexpr int kSamples = kSupersampling * kSupersampling;
  const auto [left, top] = CellCorner(cell);
  for (int v = 0; v < kCellHeight; ++v) {
    for (int u = 0; u < kCellWidth; ++u) {
      int r = kSamples / 2, g = kSamples / 2, b = kSamples / 2;
      for (int sample = 0; sample < kSamples; ++sample) {
        const Rgb8 color = finer(u * kSupersampling + sample % kSupersampling,
                                 v * kSupersampling + sample / kSupersampling);
        r += color.r, g += color.g, b += color.b;
      }
      image_(left + u, top + v) = {static_cast<std::uint8_t>(r / kSamples),
                                   static_cast<std::uint8_t>(g / kSamples),
                                   static_cast<std::uint8_t>(b / kSamples)};
    }
  }
}

void PictureSheet::DrawCaption(int cell, const std::string& text) {
  const auto [left, top] = CellCorner(cell);
  DrawText(&image_, {left + kCellWidth / 2., top + kCellHeight + kCaptionHeight / 2.}, text,
           {18, 0.5, kInk});
}

}  // namespace surfit
