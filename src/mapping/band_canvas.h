#pragma once

#include <cstdint>
#include <vector>

#include "mapping/disc_list.h"
#include "surfit/frame/model_view.h"

namespace surfit {

// Draws one band of the image. Nothing in it depends on other bands, and it meets its discs in the
// order of their surfels, so that bands can be drawn at the same time with the same outcome.
class BandCanvas {
 public:
  BandCanvas(int band, const PosedCamera& camera, const DepthNoise& noise,
             const RenderOptions& options);

  // Draws the discs of one layer into the pixels that no layer before it has drawn.
  void Draw(const std::vector<DiscList>& lists, Layer layer);

  // Writes what the pixels see.
  void WriteTo(ModelView* view) const;

 private:
  template <typename Instructions>
  void DrawWith(const std::vector<DiscList>& lists, Layer layer);
  template <typename Instructions>
  bool FindFirst(const Disc& disc);
  void FindBacks();
  template <typename Instructions>
  void Pick(const Disc& disc, float id);
  void CloseDrawnPixels();
  void WriteRow(int v, ModelView* view) const;

  const int band_, v_begin_, v_end_;
  const PosedCamera& camera_;
  const DepthNoise noise_;
  const RenderOptions& options_;
  std::vector<const Disc*> discs_;  // by id: those that pixels were open for
  // Per pixel, and one more row, as two are read and written back at once. Depths are inverse, so
  // that nearer ones are larger.
  std::vector<float> first_;  // where the ray meets the first disc; 0 if none
  // What may still be drawn is no farther: all at first, then the first surface, then nothing.
  std::vector<float> back_;
  std::vector<float> offset2_;  // of the disc drawn: squared, as a share of its radius
  std::vector<float> drawn_;    // its id, a whole number
};

}  // namespace surfit
