// Adds one surfel to a map with the public headers, and prints the map size.
#include <iostream>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

int main() try {
  const surfit::ThreadLimit limit(2);
  const surfit::PinholeCamera camera{640, 480, 525, 525, 319.5, 239.5};
  camera.Validate("the camera");
  surfit::Rigid3d world_from_camera;
  world_from_camera.translation.z() = 1;

  surfit::Surfel surfel;
  surfel.position_in_world = (world_from_camera * (2 * camera.Ray(319.5, 239.5))).cast<float>();
  surfit::SurfelMap map;
  map.Append(surfel);
  std::cout << map.size() << " surfel, " << map[0].position_in_world.z() << " m ahead\n";
  return map.size() == 1 && map[0].position_in_world.z() == 3.f ? 0 : 1;
} catch (const surfit::InputError& error) {
  std::cerr << "error: " << error.what() << "\n";
  return 1;
}
