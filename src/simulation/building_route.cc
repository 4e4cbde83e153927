#include <algorithm>
#include <cmath>
#include <vector>

#include "simulation/building.h"

namespace surfit {
namespace {

using Eigen::Vector3d;
using Row = BuildingPlan::Row;

constexpr double kEye_m = 1.4;

class RouteMaker {
 public:
  explicit RouteMaker(const BuildingPlan& plan) : plan_(plan) {}

  void Walk() {
    TourGroundFloor();
    for (int floor = 1; floor < plan_.floors; ++floor) {
      Climb(floor - 1, false, true);
      TourUpperFloor(floor);
      if (floor + 1 < plan_.floors) GoTo(plan_.WestAisle(), plan_.SouthAisle(), floor);
    }
    if (plan_.floors == 1) return;
    Along(plan_.floors - 1, true, true, false);
    for (int floor = plan_.floors - 2; floor >= 0; --floor) {
      GoTo(plan_.EastAisle(), plan_.NorthAisle(), floor + 1);
      Climb(floor, true, false);
      GoTo(plan_.EastAisle(), plan_.SouthAisle(), floor);
    }
    Along(0, false, false, false);
  }

  // Route points about 1 m apart. Small distances keep the interpolating curve from overshooting at
  // corners.
  std::vector<Vector3d> Corners() const {
    constexpr double kPiece_m = 1.0;
    std::vector<Vector3d> corners;
    for (std::size_t i = 0; i < route_.size(); ++i) {
      const Vector3d& from = route_[i];
      const Vector3d& to = route_[(i + 1) % route_.size()];
      const double length = (to - from).norm();
      if (length < 0.05) continue;  // repeated corner
      const int pieces = std::max(1, static_cast<int>(std::lround(length / kPiece_m)));
      for (int k = 0; k < pieces; ++k) {
        corners.push_back(from + static_cast<double>(k) / pieces * (to - from));
      }
    }
    return corners;
  }

 private:
  void GoTo(double x, double y, int floor) {
    route_.emplace_back(x, y, floor * BuildingPlan::kStorey_m + kEye_m);
  }

  // Appends the way up the stairs from `floor` to the next floor, or down. Stairs lead from the
  // south end to the north end.
  void Climb(int floor, bool east, bool upwards) {
    const double x = plan_.StaircaseAisle(east), edge = BuildingPlan::kCorridor_m;
    std::vector<Vector3d> way = {
        {x, plan_.SouthAisle(), floor * BuildingPlan::kStorey_m + kEye_m},
        {x, edge, floor * BuildingPlan::kStorey_m + kEye_m},
        {x, BuildingPlan::Depth() - edge, (floor + 1) * BuildingPlan::kStorey_m + kEye_m},
        {x, plan_.NorthAisle(), (floor + 1) * BuildingPlan::kStorey_m + kEye_m}};
    if (!upwards) std::reverse(way.begin(), way.end());
    route_.insert(route_.end(), way.begin(), way.end());
    if (upwards) GoTo(plan_.WestAisle(), plan_.NorthAisle(), floor + 1);
  }

  // Appends a visit of a room: in through the doorway, once around the centre, and out.
  void Visit(const BuildingPlan::Place& room) {
    constexpr double kMiddle_m = BuildingPlan::kRoomWidth_m / 2, kAside_m = 0.8;
    for (const Vector3d& corner :
         {Vector3d(kMiddle_m, -1.5, kEye_m), Vector3d(kMiddle_m, -0.2, kEye_m),
          Vector3d(kMiddle_m, 0.9, kEye_m), Vector3d(kMiddle_m - kAside_m, 1.5, kEye_m),
          Vector3d(kMiddle_m - kAside_m, 2.5, kEye_m), Vector3d(kMiddle_m, 3.0, kEye_m),
          Vector3d(kMiddle_m + kAside_m, 2.5, kEye_m), Vector3d(kMiddle_m + kAside_m, 1.5, kEye_m),
          Vector3d(kMiddle_m, 0.9, kEye_m), Vector3d(kMiddle_m, -0.2, kEye_m),
          Vector3d(kMiddle_m, -1.5, kEye_m)}) {
      route_.push_back(room.world_from_room * corner);
    }
  }

  void Along(int floor, bool north, bool eastwards, bool visit) {
    const double y = north ? plan_.NorthAisle() : plan_.SouthAisle();
    GoTo(eastwards ? plan_.WestAisle() : plan_.EastAisle(), y, floor);
    for (int i = 0; visit && i < plan_.columns; ++i) {
      const int column = eastwards ? i : plan_.columns - 1 - i;
      for (const BuildingPlan::Place& room : plan_.rooms) {
        const bool is_here = room.floor == floor && room.column == column;
        const bool is_off_north = room.row == Row::kInnerNorth || room.row == Row::kOuterNorth;
        if (is_here && is_off_north == north) Visit(room);
      }
    }
    GoTo(eastwards ? plan_.EastAisle() : plan_.WestAisle(), y, floor);
  }

  void TourGroundFloor() {
    Along(0, false, true, true);
    Along(0, true, false, true);
    GoTo(plan_.WestAisle(), plan_.SouthAisle(), 0);
  }
  void TourUpperFloor(int floor) {
    Along(floor, true, true, true);
    Along(floor, false, false, true);
    GoTo(plan_.WestAisle(), plan_.NorthAisle(), floor);
  }

  const BuildingPlan& plan_;
  std::vector<Vector3d> route_;
};

}  // namespace

std::vector<Vector3d> BuildingRoute(const BuildingPlan& plan) {
  RouteMaker maker(plan);
  maker.Walk();
  return maker.Corners();
}

}  // namespace surfit
