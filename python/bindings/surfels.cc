#include "bindings/surfels.h"

#include "bindings/arrays.h"
#include "bindings/bind.h"

namespace surfit::python {
SurfelColumns ColumnsOf(const SurfelMap& map) {
  SurfelColumns columns;
  for (const std::int32_t id : map.Ids()) {
    const Surfel surfel = map[id];
    columns.position_in_world.push_back(surfel.position_in_world);
    columns.normal_in_world.push_back(surfel.normal_in_world);
    columns.color.push_back(surfel.color);
    columns.radius_m.push_back(surfel.radius_m);
    columns.confidence.push_back(surfel.confidence);
    columns.first_seen.push_back(surfel.first_seen);
    columns.last_seen.push_back(surfel.last_seen);
  }
  return columns;
}

void BindSurfels(py::module_& module) {
  py::class_<SurfelColumns> surfels(module, "Surfels",
                                    "Surfels of a map at one time. Arrays are views without copy.");
  surfels.def("__len__", [](const SurfelColumns& columns) { return columns.radius_m.size(); });
  BindRows<float>(&surfels, FIELD(SurfelColumns, position_in_world), "N x 3, float32, metres");
  BindRows<float>(&surfels, FIELD(SurfelColumns, normal_in_world),
                  "N x 3, float32, unit length, towards the observer");
  BindRows<std::uint8_t>(&surfels, FIELD(SurfelColumns, color), "N x 3, uint8, red first");
  BindRows<float>(&surfels, FIELD(SurfelColumns, radius_m), "N, float32, metres");
  BindRows<float>(&surfels, FIELD(SurfelColumns, confidence),
                  "N, float32, sum of the weights of observations");
  BindRows<std::int32_t>(&surfels, FIELD(SurfelColumns, first_seen), "N, int32, frame index");
  BindRows<std::int32_t>(&surfels, FIELD(SurfelColumns, last_seen), "N, int32, frame index");
}

}  // namespace surfit::python
