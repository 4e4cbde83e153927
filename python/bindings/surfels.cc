#include "bindings/surfels.h"

#include "bindings/arrays.h"
#include "bindings/bind.h"

namespace py = pybind11;

namespace surfit::python {
namespace {

// Binds a column as an array of the scalars that its elements are made of.
template <typename Scalar, typename Element>
void BindColumn(const char* name, std::vector<Element> SurfelColumns::*column, const char* doc,
                py::class_<SurfelColumns>* surfels) {
  constexpr auto kWidth = static_cast<py::ssize_t>(sizeof(Element) / sizeof(Scalar));
  const auto view = [column](const py::object& self) {
    const std::vector<Element>& elements = self.cast<const SurfelColumns&>().*column;
    std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(elements.size())};
    if (kWidth > 1) shape.push_back(py::ssize_t{kWidth});
    return ViewOf(reinterpret_cast<const Scalar*>(elements.data()), shape, self);
  };
  surfels->def_property_readonly(name, view, doc);
}

}  // namespace

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
  py::class_<SurfelColumns> surfels(
      module, "Surfels", "The surfels of a map at one moment. The arrays are views of its memory.");
  surfels.def("__len__", [](const SurfelColumns& columns) { return columns.radius_m.size(); });
  BindColumn<float>("position_in_world", &SurfelColumns::position_in_world,
                    "N x 3, float32, metres", &surfels);
  BindColumn<float>("normal_in_world", &SurfelColumns::normal_in_world,
                    "N x 3, float32, unit length, towards the observer", &surfels);
  BindColumn<std::uint8_t>("color", &SurfelColumns::color, "N x 3, uint8, red first", &surfels);
  BindColumn<float>("radius_m", &SurfelColumns::radius_m, "N, float32, metres", &surfels);
  BindColumn<float>("confidence", &SurfelColumns::confidence,
                    "N, float32, sum of the weights of its observations", &surfels);
  BindColumn<std::int32_t>("first_seen", &SurfelColumns::first_seen, "N, int32, frame index",
                           &surfels);
  BindColumn<std::int32_t>("last_seen", &SurfelColumns::last_seen, "N, int32, frame index",
                           &surfels);
}

}  // namespace surfit::python
