#include <array>
#include <functional>
#include <map>

#include "simulation/building.h"
#include "simulation/item.h"
#include "simulation/room.h"
#include "surfit/core/error.h"
#include "surfit/simulation/scene.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

constexpr double kDoorwayY_m = 2.4;
constexpr double kCameraZ_m = 1.4;

// Closed route through the doorways at x = first and x = second. The route passes each room on one
// side, and returns on the other side. The length is about 22.5 m, for 1500 frames with steps of 15
// mm.
std::vector<Vector3d> Route(double first, double second) {
  constexpr double kLength_m = 21, kSide_m = 0.8, kBesideDoorway_m = 0.7;
  const double reach = (kLength_m - 2 * (second - first)) / 4 - 0.15;
  std::vector<Vector3d> route;
  const auto go = [&](double x, double y) { route.emplace_back(x, kDoorwayY_m + y, kCameraZ_m); };
  const auto pass = [&](double doorway, double direction) {
    go(doorway - direction * kBesideDoorway_m, 0);
    go(doorway + direction * kBesideDoorway_m, 0);
  };
  go(first - 0.6 * reach, -kSide_m);
  pass(first, 1);
  go((first + second) / 2, -kSide_m);
  pass(second, 1);
  go(second + 0.6 * reach, -kSide_m);
  go(second + reach, 0);
  go(second + 0.6 * reach, kSide_m);
  pass(second, -1);
  go((first + second) / 2, kSide_m);
  pass(first, -1);
  go(first - 0.6 * reach, kSide_m);
  go(first - reach, 0);
  return route;
}

// Three furnished rooms along x with doorways, and a closed route (Scene::route).
Scene MakeThreeRooms(std::uint64_t seed) {
  constexpr int kRooms = 3, kEastWall = 1, kWestWall = 3;
  constexpr double kBetween_m = 2 * RoomPlan::kThick_m;
  Scene scene;
  Random random(seed);
  std::array<double, kRooms - 1> doorways;
  double x = 0;
  for (int i = 0; i < kRooms; ++i) {
    RoomPlan room{&scene, &random, random.Uniform(5, 6.5), random.Uniform(4.8, 5.6), {x, 0, 0}};
    if (i > 0) room.doorways.push_back({kWestWall, room.depth_m - kDoorwayY_m});
    if (i + 1 < kRooms) room.doorways.push_back({kEastWall, kDoorwayY_m});
    AddFurnishedRoom(room);
    x += room.width_m + kBetween_m;
    if (i + 1 < kRooms) doorways[i] = x - kBetween_m / 2;
  }
  scene.route = Route(doorways[0], doorways[1]);
  for (const Vector3d& corner : scene.route) scene.camera_space.extend(corner);
  return scene;
}

const Color kPale(0.65f, 0.62f, 0.55f), kDark(0.25f, 0.2f, 0.16f), kBlue(0.2f, 0.3f, 0.5f);

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

using SceneMaker = std::function<Scene(std::uint64_t, const BuildingOptions&)>;

SceneMaker Fixed(Scene (*maker)(std::uint64_t)) {
  return [=](std::uint64_t seed, const BuildingOptions&) { return maker(seed); };
}

const std::map<std::string, SceneMaker>& Makers() {
  static const std::map<std::string, SceneMaker> makers = {{"building", &MakeBuilding},
                                                           {"room", Fixed(&MakeRoom)},
                                                           {"three_rooms", Fixed(&MakeThreeRooms)},
                                                           {"three_planes", Fixed(&ThreePlanes)},
                                                           {"wall", Fixed(&Wall)},
                                                           {"sphere", Fixed(&Ball)},
                                                           {"corridor", Fixed(&Corridor)}};
  return makers;
}

}  // namespace

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : Makers()) names.push_back(name);
  return names;
}

Scene MakeScene(const std::string& name, std::uint64_t seed, const BuildingOptions& building) {
  const auto maker = Makers().find(name);
  if (maker != Makers().end()) return maker->second(seed, building);
  std::string known;
  for (const std::string& each : SceneNames()) known += (known.empty() ? "" : ", ") + each;
  throw InputError("scene is '", name, "', must be one of ", known);
}

}  // namespace surfit
