#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "simulation/random.h"
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

// The shortest turn that brings the z axis into a direction, of any length but zero.
// (Eigen's FromTwoVectors brings a singular value decomposition along, which takes half a minute to
// compile under sanitizers.)
Eigen::Quaterniond TurnZInto(const Eigen::Vector3d& direction);

// A piece of furniture while it is being put together: adds parts to the scene in its own frame,
// z up, metres.
class Item {
 public:
  Item(Scene* scene, const Rigid3d& world_from_item) : scene_(scene), frame_(world_from_item) {}

  // A frame within this one, turned about z.
  Item At(const Eigen::Vector3d& position, double turn_rad = 0) const;
  Eigen::Vector3d InWorld(const Eigen::Vector3d& point) const { return frame_ * point; }
  // A camera path looks at this point.
  void Target(const Eigen::Vector3d& point) const { scene_->targets.push_back(frame_ * point); }

  void Add(ShapePtr shape, const Rigid3d& item_from_part, const Texture& texture,
           float glow = 0) const;
  void Add(ShapePtr shape, const Eigen::Vector3d& center, const Texture& texture,
           float glow = 0) const;
  void Box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Texture& texture) const;
  void RoundedBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double edge_radius,
                  const Texture& texture) const;
  // A round rod; flat ends.
  void Rod(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
           const Texture& texture) const;
  // A cut cone on its bottom's centre.
  void Cone(const Eigen::Vector3d& bottom, double bottom_radius, double top_radius, double height,
            const Texture& texture, float glow = 0) const;

 private:
  Scene* scene_;
  Rigid3d frame_;
};

// What stands on the floor: the middle of the back edge is the origin, y points away from the wall.
void AddBookshelf(const Item& item, double width_m, Random* random);
void AddSofa(const Item& item, double width_m, Random* random);
void AddCabinet(const Item& item, double width_m, Random* random);
void AddCrates(const Item& item, Random* random);
// These have their origin below their middle.
void AddTable(const Item& item, double width_m, double depth_m, Random* random);
void AddChair(const Item& item, Random* random);  // its back at -y
void AddFloorLamp(const Item& item, Random* random);
void AddPlant(const Item& item, Random* random);

// What stands on other things: the origin is below the middle.
void AddCup(const Item& item, Random* random);
void AddPileOfBooks(const Item& item, Random* random);
void AddBowlOfFruit(const Item& item, Random* random);
void AddVase(const Item& item, Random* random);
void AddRing(const Item& item, Random* random);
void AddMonitor(const Item& item, Random* random);
// A row of upright books from x = 0 to at most the width, their backs at y = depth_m.
void AddRowOfBooks(const Item& item, double width_m, double depth_m, double height_m,
                   Random* random);
// Small things here and there on a table top of this size.
void AddClutter(const Item& item, double width_m, double depth_m, Random* random);

// What hangs on a wall: the origin is the middle of its lower edge, on the wall.
void AddPoster(const Item& item, double width_m, double height_m, Random* random);
void AddDoor(const Item& item, Random* random);
void AddCurtain(const Item& item, double width_m, double height_m, Random* random);
void AddWallShelf(const Item& item, double width_m, Random* random);
void AddClock(const Item& item, Random* random);

// Colours of painted or woven things, not too dark for a depth camera's taste.
Color RandomPaint(Random* random);
Texture RandomWood(int grain_axis, Random* random);

}  // namespace surfit
