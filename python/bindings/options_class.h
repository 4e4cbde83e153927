#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <string>
#include <typeindex>

#include "bindings/pose_caster.h"
#include "surfit/core/options.h"

namespace surfit::python {

// "Name(a=1, b='x')", of all properties of the object's class.
std::string ReprOfOptions(const pybind11::object& options);

// Sets the named options. Throws TypeError for a name that is none.
void SetOptions(const pybind11::kwargs& values, pybind11::object options);

// How Python sees a field of some type.
struct FieldType {
  std::string name;  // in docstrings
  std::function<pybind11::object(void* field, pybind11::handle options)> get;
  std::function<void(void* field, pybind11::handle value)> set;
};

// Of types that are neither plain nor known here Python sees the text.
void AddFieldType(std::type_index type, FieldType field_type);

// Makes each option of the table a property; `table_of` binds the table to an object.
void AddProperties(pybind11::object options_class, const OptionTable& defaults,
                   const std::function<OptionTable(pybind11::handle)>& table_of);

// A plain struct as a Python class that is made from keywords; its attributes are added later.
template <typename T>
pybind11::class_<T> BindPlain(pybind11::module_& module, const char* name, const char* doc) {
  namespace py = pybind11;
  py::class_<T> plain(module, name, doc);
  plain.def(py::init([](const py::kwargs& values) {
              T options;
              SetOptions(values, py::cast(&options, py::return_value_policy::reference));
              return options;
            }),
            "Defaults, but for the options named.");
  plain.def("__repr__", &ReprOfOptions);
  plain.def("__copy__", [](const T& options) { return T(options); });
  plain.def(
      "__deepcopy__", [](const T& options, const py::dict&) { return T(options); },
      py::arg("memo"));
  AddFieldType(typeid(T), {std::string("surfit.") + name,
                           [](void* field, py::handle options) {
                             return py::cast(static_cast<T*>(field),
                                             py::return_value_policy::reference_internal, options);
                           },
                           [](void* field, py::handle value) {
                             *static_cast<T*>(field) = value.cast<const T&>();
                           }});
  return plain;
}

// A struct of options, its attributes by its table.
template <typename T>
void BindOptions(pybind11::module_& module, const char* name, const char* doc) {
  namespace py = pybind11;
  py::class_<T> options_class = BindPlain<T>(module, name, doc);
  T defaults;
  AddProperties(options_class, TableOf(&defaults),
                [](py::handle options) { return TableOf(options.cast<T*>()); });
  options_class.def(
      "validate", [](const T& options) { Validate(options); },
      "Raises ValueError naming an option, its value and the constraint it breaks.");
}

}  // namespace surfit::python
