#include "bindings/options_class.h"

namespace py = pybind11;

namespace surfit::python {

std::vector<std::string>& IncompleteOptions() {
  static std::vector<std::string> sentences;
  return sentences;
}

std::string ReprOfOptions(const py::object& options) {
  const py::type type = py::type::of(options);
  const py::object property = py::module_::import("builtins").attr("property");
  std::string text;
  for (const auto& item : type.attr("__dict__").attr("items")()) {
    const auto name_and_member = item.cast<py::tuple>();
    if (!py::isinstance(name_and_member[1], property)) continue;
    const auto name = name_and_member[0].cast<std::string>();
    text += (text.empty() ? "" : ", ") + name + "=" +
            py::repr(options.attr(name.c_str())).cast<std::string>();
  }
  return type.attr("__name__").cast<std::string>() + "(" + text + ")";
}

void SetOptions(const py::kwargs& values, py::object options) {
  for (const auto& [name, value] : values) {
    if (!py::hasattr(options, name)) {
      throw py::type_error(py::type::of(options).attr("__name__").cast<std::string>() +
                           " has no option '" + name.cast<std::string>() + "'");
    }
    py::setattr(options, name, value);
  }
}

}  // namespace surfit::python
