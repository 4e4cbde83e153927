#include "run/digest.h"

#include <gtest/gtest.h>

namespace surfit {
namespace {

SurfelMap OneSurfel() {
  SurfelMap map;
  Surfel surfel;
  surfel.position_in_world = {1, 2, 3};
  surfel.confidence = 4;
  map.Append(surfel);
  return map;
}

TEST(Digest, OfNothingIsTheOffsetBasisOfFnv1a) {
  EXPECT_EQ(Digest({}, SurfelMap()), "cbf29ce484222325");
}

TEST(Digest, NoticesTheLastBitOfEveryPart) {
  const Trajectory trajectory = {{1.0, Rigid3d()}};
  const std::string digest = Digest(trajectory, OneSurfel());
  EXPECT_EQ(Digest(trajectory, OneSurfel()), digest);

  Trajectory moved = trajectory;
  moved[0].world_from_camera.translation.z() = 5e-324;
  EXPECT_NE(Digest(moved, OneSurfel()), digest);
  Trajectory later = trajectory;
  later[0].stamp_s = std::nextafter(1.0, 2.0);
  EXPECT_NE(Digest(later, OneSurfel()), digest);

  using Block = SurfelBlock;
  for (const auto array : {&Block::x, &Block::y, &Block::z, &Block::nx, &Block::ny, &Block::nz,
                           &Block::radius_m, &Block::confidence}) {
    SurfelMap map = OneSurfel();
    float& number = (map.block(0).*array)[0];
    number = std::nextafter(number, 100.f);
    EXPECT_NE(Digest(trajectory, map), digest);
  }
  for (const auto array : {&Block::red, &Block::green, &Block::blue}) {
    SurfelMap map = OneSurfel();
    ++(map.block(0).*array)[0];
    EXPECT_NE(Digest(trajectory, map), digest);
  }
  for (const auto array : {&Block::first_seen, &Block::last_seen}) {
    SurfelMap map = OneSurfel();
    ++(map.block(0).*array)[0];
    EXPECT_NE(Digest(trajectory, map), digest);
  }
}

}  // namespace
}  // namespace surfit
