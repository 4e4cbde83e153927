#include "mapping/map/block_observations.h"

#include <cmath>
#include <cstring>

#include "surfit/core/lanes.h"

namespace surfit {

void BlockObservations::Clear() {
  mask_ = within_mask_ = 0;
  std::memset(weight_, 0, sizeof(weight_));
  std::memset(shape_weight_, 0, sizeof(shape_weight_));
  std::memset(color_weight_, 0, sizeof(color_weight_));
}

void BlockObservations::Add(int place, const SurfelObservation& seen) {
  const std::uint64_t bit = std::uint64_t{1} << place;
  mask_ |= bit;
  if (!seen.at_edge) within_mask_ |= bit;
  weight_[place] = seen.weight;
  shape_weight_[place] = seen.shape_weight;
  color_weight_[place] = seen.color_weight;
  x_[place] = seen.position_in_world.x();
  y_[place] = seen.position_in_world.y();
  z_[place] = seen.position_in_world.z();
  nx_[place] = seen.normal_in_world.x();
  ny_[place] = seen.normal_in_world.y();
  nz_[place] = seen.normal_in_world.z();
  radius_m_[place] = seen.radius_m;
  red_[place] = seen.color.x();
  green_[place] = seen.color.y();
  blue_[place] = seen.color.z();
}

void BlockObservations::MergeInto(SurfelBlock* block, float max_confidence) const {
  WithInstructions([&](auto) {
    MergeShapes(block);
    MergeColors(block);
    for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
      const float sum = block->Confidence(k) + weight_[k];
      const float bounded = max_confidence < sum ? max_confidence : sum;
      const std::uint16_t small = SmallSum::From(bounded);
      block->confidence[k] = weight_[k] > 0.f ? small : block->confidence[k];
    }
  });
  block->at_edge &= ~within_mask_;
}

void BlockObservations::MergeShapes(SurfelBlock* block) const {
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const bool moves = shape_weight_[k] > 0.f;
    const float inverse_sum = 1.f / (moves ? block->Confidence(k) + weight_[k] : 1.f);
    const float share = shape_weight_[k] * inverse_sum;
    const float x = block->X(k), y = block->Y(k), z = block->Z(k);
    const std::uint16_t new_x = SmallCoordinate::From(x + share * (x_[k] - x) - block->origin[0]);
    const std::uint16_t new_y = SmallCoordinate::From(y + share * (y_[k] - y) - block->origin[1]);
    const std::uint16_t new_z = SmallCoordinate::From(z + share * (z_[k] - z) - block->origin[2]);
    block->x[k] = moves ? new_x : block->x[k];
    block->y[k] = moves ? new_y : block->y[k];
    block->z[k] = moves ? new_z : block->z[k];
    const float before_x = SmallUnit::ToFloat(block->nx[k]);
    const float before_y = SmallUnit::ToFloat(block->ny[k]);
    const float before_z = SmallUnit::ToFloat(block->nz[k]);
    const float nx = before_x + share * (nx_[k] - before_x);
    const float ny = before_y + share * (ny_[k] - before_y);
    const float nz = before_z + share * (nz_[k] - before_z);
    const float length2 = nx * nx + (ny * ny + nz * nz);
    const float length = std::sqrt(length2 > 0.f ? length2 : 1.f);
    block->nx[k] = SmallUnit::From(moves ? nx / length : before_x);
    block->ny[k] = SmallUnit::From(moves ? ny / length : before_y);
    block->nz[k] = SmallUnit::From(moves ? nz / length : before_z);
    const float radius_m = SmallLength::ToFloat(block->radius[k]);
    block->radius[k] =
        SmallLength::From(moves & (radius_m_[k] < radius_m) ? radius_m_[k] : radius_m);
  }
}

void BlockObservations::MergeColors(SurfelBlock* block) const {
  constexpr int kBits = ~7;
  constexpr float kSteps = 256.f;
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const int red = block->red[k], green = block->green[k], blue = block->blue[k];
    const bool gains = color_weight_[k] > 0.f;
    const int byte = (blue & 7) | (green & 7) << 3 | (red & 3) << 6;
    const float before = WeightByte::ToFloat(static_cast<std::uint8_t>(byte));
    const float sum = gains ? before + color_weight_[k] : 1.f;
    const float share = color_weight_[k] / sum;
    const int weight = WeightByte::From(sum);
    const auto mixed = [&](int old, float seen, int bits) {
      const float was = static_cast<float>(old & kBits) / kSteps;
      const float value = was + share * (seen - was);
      return static_cast<int>(32.f * (gains ? value : 0.f) + 0.5f) << 3 | bits;
    };
    const int new_red = mixed(red, red_[k], weight >> 6);
    const int new_green = mixed(green, green_[k], weight >> 3 & 7);
    const int new_blue = mixed(blue, blue_[k], weight & 7);
    block->red[k] = static_cast<std::uint16_t>(gains ? new_red : red);
    block->green[k] = static_cast<std::uint16_t>(gains ? new_green : green);
    block->blue[k] = static_cast<std::uint16_t>(gains ? new_blue : blue);
  }
}

}  // namespace surfit
