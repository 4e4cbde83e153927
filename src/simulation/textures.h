#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "surfit/simulation/scene.h"

namespace surfit {

// Procedural textures in an object's own frame; lengths in metres, colours linear in [0, 1].
using Color = Eigen::Vector3f;

Texture Plain(const Color& color);
// A colour with faint large blotches and grain: plaster, fabric.
Texture Mottled(const Color& color, double scale_m, float contrast, std::uint64_t seed);
// Cubes of two colours.
Texture Checks(const Color& a, const Color& b, double size_m);
// Layers of two colours across an axis (0, 1 or 2).
Texture Stripes(const Color& a, const Color& b, double width_m, int axis);
// Grain along an axis.
Texture Wood(const Color& light, const Color& dark, int grain_axis, std::uint64_t seed);
// Floor boards along x, each of its own shade, with narrow joints.
Texture Boards(const Color& light, const Color& dark, double width_m, double length_m,
               std::uint64_t seed);
// A framed abstract picture of width x height metres in the x-z plane.
Texture Poster(double width_m, double height_m, std::uint64_t seed);
// A rug in the x-y plane: a border and a pattern.
Texture Rug(double width_m, double depth_m, std::uint64_t seed);

}  // namespace surfit
