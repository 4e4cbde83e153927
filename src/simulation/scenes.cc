#include "surfit/simulation/scenes.h"

#include <map>

#include "simulation/room.h"
#include "simulation/textures.h"
#include "simulation/turn.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

const Color kPale(0.65f, 0.62f, 0.55f), kDark(0.25f, 0.2f, 0.16f), kBlue(0.2f, 0.3f, 0.5f);

// A half space whose face passes through a point.
void AddPlane(const Vector3d& point, const Vector3d& normal, const Texture& texture, Scene* scene) {
  scene->Add(MakeHalfSpace(), Rigid3d(TurnZInto(normal), point), texture);
}

void AddFloor(Scene* scene) {
  AddPlane(Vector3d::Zero(), Vector3d::UnitZ(), Checks(kPale, kDark, 0.25), scene);
}

void Film(const Vector3d& low, const Vector3d& high, const std::vector<Vector3d>& targets,
          Scene* scene) {
  scene->camera_space = Eigen::AlignedBox3d(low, high);
  scene->targets = targets;
  scene->lights = {{(low + high) / 2 + Vector3d(0.6, -0.4, 0.9), 0.8f, false}};
}

Scene ThreePlanes(std::uint64_t seed) {
  Scene scene;
  AddFloor(&scene);
  AddPlane(Vector3d::Zero(), Vector3d::UnitX(), Mottled(kPale, 0.2, 0.8f, seed), &scene);
  AddPlane(Vector3d::Zero(), Vector3d::UnitY(), Mottled(kBlue, 0.2, 0.8f, seed + 1), &scene);
  Film({1, 1, 0.8}, {2.5, 2.5, 1.8}, {{0, 0, 0}, {0, 0, 1}, {0, 0.8, 0.3}, {0.8, 0, 0.4}}, &scene);
  return scene;
}

Scene Wall(std::uint64_t seed) {
  Scene scene;
  AddPlane({0, 2, 0}, -Vector3d::UnitY(), Mottled(kPale, 0.15, 1.2f, seed), &scene);
  Film({-1, -0.2, 0.6}, {1, 0.8, 1.8}, {{-0.8, 2, 0.8}, {0.8, 2, 1}, {0, 2, 1.7}, {0.2, 2, 0.6}},
       &scene);
  return scene;
}

Scene Ball(std::uint64_t seed) {
  Scene scene;
  AddFloor(&scene);
  scene.Add(MakeSphere(0.5), Rigid3d(Eigen::Quaterniond::Identity(), {0, 2, 1}),
            Mottled(kBlue, 0.1, 1.2f, seed));
  Film({-1, -0.2, 0.7}, {1, 0.8, 1.7}, {{-0.4, 2, 1}, {0.4, 2, 0.8}, {0, 2, 1.4}, {0, 2, 0.5}},
       &scene);
  return scene;
}

Scene Corridor(std::uint64_t seed) {
  Scene scene;
  AddFloor(&scene);
  AddPlane({0, 0, 2.4}, -Vector3d::UnitZ(), Plain(kPale), &scene);
  AddPlane({-1, 0, 0}, Vector3d::UnitX(), Mottled(kPale, 0.3, 0.3f, seed), &scene);
  AddPlane({1, 0, 0}, -Vector3d::UnitX(), Mottled(kPale, 0.3, 0.3f, seed + 1), &scene);
  Film({-0.4, -2, 1}, {0.4, 2, 1.6}, {{-1, 3.5, 1}, {1, 4, 1.2}, {0, 4.5, 0.4}, {0.3, 4, 1.8}},
       &scene);
  return scene;
}

const std::map<std::string, Scene (*)(std::uint64_t)>& Makers() {
  static const std::map<std::string, Scene (*)(std::uint64_t)> makers = {
      {"room", &MakeRoom},
      {"three_rooms", &MakeThreeRooms},
      {"three_planes", &ThreePlanes},
      {"wall", &Wall},
      {"sphere", &Ball},
      {"corridor", &Corridor}};
  return makers;
}

}  // namespace

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : Makers()) names.push_back(name);
  return names;
}

Scene MakeScene(const std::string& name, std::uint64_t seed) {
  const auto maker = Makers().find(name);
  if (maker != Makers().end()) return maker->second(seed);
  std::string known;
  for (const std::string& each : SceneNames()) known += (known.empty() ? "" : ", ") + each;
  throw InputError(Concat("scene is '", name, "', must be one of ", known));
}

}  // namespace surfit
