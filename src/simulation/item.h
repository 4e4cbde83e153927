#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "simulation/random.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// Procedural textures in the object frame. Lengths in m, colours linear in [0, 1].
using Color = Eigen::Vector3f;

// One colour.
Texture Plain(const Color& color);
// Colour with fractal noise: plaster, fabric.
Texture Mottled(const Color& color, double scale_m, float contrast, std::uint64_t seed);
// Three-dimensional checkerboard.
Texture Checks(const Color& a, const Color& b, double size_m);
// Layers of two colours, perpendicular to an axis (0, 1 or 2).
Texture Stripes(const Color& a, const Color& b, double width_m, int axis);
// Wood with grain along an axis (0, 1 or 2).
Texture Wood(const Color& light, const Color& dark, int grain_axis, std::uint64_t seed);
// Floor boards along x with random shades and narrow joints.
Texture Boards(const Color& light, const Color& dark, double width_m, double length_m,
               std::uint64_t seed);
// Framed random picture in x and z. Its centre is the origin.
Texture Poster(double width_m, double height_m, std::uint64_t seed);
// Random pattern with a border, in x and y. Its centre is the origin.
Texture Rug(double width_m, double depth_m, std::uint64_t seed);

// Shortest rotation from the z axis to `direction`, which must not be zero.
// Quaterniond::FromTwoVectors() would take 30 s to compile with sanitizers.
Eigen::Quaterniond TurnZInto(const Eigen::Vector3d& direction);

// Furniture. Adds parts to the scene in the item frame: z up, m. The scene must outlive it. Not
// thread-safe.
class Item {
 public:
  Item(Scene* scene, const Rigid3d& world_from_item) : scene_(scene), frame_(world_from_item) {}

  // Frame inside this frame, turned about z.
  Item At(const Eigen::Vector3d& position, double turn_rad = 0) const;
  Eigen::Vector3d InWorld(const Eigen::Vector3d& point) const { return frame_ * point; }
  void Target(const Eigen::Vector3d& point) const { scene_->targets.push_back(frame_ * point); }

  // Add a solid to the scene. `glow` as in SceneObject.
  void Add(ShapePtr shape, const Rigid3d& item_from_part, const Texture& texture,
           float glow = 0) const;
  void Add(ShapePtr shape, const Eigen::Vector3d& center, const Texture& texture,
           float glow = 0) const;
  void Box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Texture& texture) const;
  void RoundedBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double edge_radius,
                  const Texture& texture) const;
  // Cylinder.
  void Rod(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
           const Texture& texture) const;
  // Frustum of a cone; `bottom` is the centre of its bottom face.
  void Cone(const Eigen::Vector3d& bottom, double bottom_radius, double top_radius, double height,
            const Texture& texture, float glow = 0) const;

 private:
  Scene* scene_;
  Rigid3d frame_;
};

// Items on the floor; the origin is in the middle of the back edge, and y points away from the
// wall.
void AddBookshelf(const Item& item, double width_m, Random* random);
void AddSofa(const Item& item, double width_m, Random* random);
void AddCabinet(const Item& item, double width_m, Random* random);
void AddCrates(const Item& item, Random* random);
// Items on the floor; the origin is below the centre.
void AddTable(const Item& item, double width_m, double depth_m, Random* random);
void AddChair(const Item& item, Random* random);  // back at -y
void AddFloorLamp(const Item& item, Random* random);
void AddPlant(const Item& item, Random* random);

// Items on other items; the origin is below the centre.
void AddCup(const Item& item, Random* random);
void AddPileOfBooks(const Item& item, Random* random);
void AddBowlOfFruit(const Item& item, Random* random);
void AddVase(const Item& item, Random* random);
void AddRing(const Item& item, Random* random);
void AddMonitor(const Item& item, Random* random);
// Row of upright books from x = 0 to x = width_m, with spines at y <= depth_m.
void AddRowOfBooks(const Item& item, double width_m, double depth_m, double height_m,
                   Random* random);
// Random items on an area of width_m x depth_m around the origin.
void AddClutter(const Item& item, double width_m, double depth_m, Random* random);

// Items on a wall; the origin is in the middle of the lower edge.
void AddPoster(const Item& item, double width_m, double height_m, Random* random);
void AddDoor(const Item& item, Random* random);
void AddCurtain(const Item& item, double width_m, double height_m, Random* random);
void AddWallShelf(const Item& item, double width_m, Random* random);
void AddClock(const Item& item, Random* random);

// Random colour of paint or fabric that a depth camera can see.
Color RandomPaint(Random* random);
Texture RandomWood(int grain_axis, Random* random);

}  // namespace surfit
