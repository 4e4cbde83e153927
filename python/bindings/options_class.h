#pragma once

#include <functional>
#include <string>
#include <typeindex>

#include "bindings/bind.h"
#include "surfit/core/options.h"

namespace surfit::python {

// Text "Name(a=1, b='x')" with all properties.
std::string ReprOfOptions(const py::object& options);

// Text "Name(a=1, b='x')" with the properties that are numbers, strings, bools or None. Other
// properties may be long.
std::string ReprOfReport(const py::object& report);

// Copies of the properties, by name.
py::dict PropertiesOf(const py::object& object);

// Support of pickle: a report is restored as a types.SimpleNamespace with the same properties.
py::tuple ReductionOf(const py::object& report);

// Makes old names of attributes (PresentName()) work, with a DeprecationWarning.
void AddOldNames(py::object python_class);

// Binds a result (of a frame, a run, ...), with repr() and pickle support.
template <typename T>
py::class_<T> BindReport(py::module_& module, const char* name, const char* doc) {
  py::class_<T> report(module, name, doc);
  report.def("__repr__", &ReprOfReport);
  report.def("__reduce__", &ReductionOf,
             "Pickle restores a types.SimpleNamespace with the same attributes.");
  AddOldNames(report);
  return report;
}

// Sets options by name. Throws TypeError for an unknown name.
void SetOptions(const py::kwargs& values, py::object options);

// Conversion of fields of a type between C++ and Python.
struct FieldType {
  std::string name;  // type in docstrings
  std::function<py::object(void* field, py::handle options)> get;
  std::function<void(void* field, py::handle value)> set;
};

// Registers a type. Fields of types without registration are strings in Python.
void AddFieldType(std::type_index type, FieldType field_type);

// Adds each option of the table as a property. `table_of` returns the table of an object.
void AddProperties(py::object options_class, const OptionTable& defaults,
                   const std::function<OptionTable(py::handle)>& table_of);

// Options with the name of their class, for validation. Required options may be missing, because
// they can be set later.
template <typename T>
struct NamedOptions {
  T* options;
  std::string name;

  void Visit(OptionVisitor& v) { v.AddPart(*options, Option(name, "", OptionalPart())); }
};

// Throws InputError with class, option, value and constraint.
template <typename T>
void RequireValues(T* options, const std::string& name) {
  NamedOptions<T> named = {options, name};
  ValidateTable(TableOf(&named));
}

// Binds a plain struct, which Python constructs from keywords. `check` may reject them. Attributes
// are added later.
template <typename T>
py::class_<T> BindPlain(
    py::module_& module, const char* name, const char* doc,
    void (*check)(T*, const std::string&) = [](T*, const std::string&) {}) {
  namespace py = pybind11;
  py::class_<T> plain(module, name, doc);
  plain.def(py::init([name, check](const py::kwargs& values) {
              T options;
              SetOptions(values, py::cast(&options, py::return_value_policy::reference));
              check(&options, name);
              return options;
            }),
            "Default values, except for the given keywords.");
  plain.def("__repr__", &ReprOfOptions);
  plain.def(py::pickle([](const py::object& options) { return PropertiesOf(options); },
                       [](const py::dict& values) {
                         T options;
                         SetOptions(py::kwargs(values),
                                    py::cast(&options, py::return_value_policy::reference));
                         return options;
                       }));
  AddOldNames(plain);
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

// Binds a struct of options. Its table defines the attributes.
template <typename T>
void BindOptions(py::module_& module, const char* name, const char* doc) {
  namespace py = pybind11;
  py::class_<T> options_class = BindPlain<T>(module, name, doc, &RequireValues<T>);
  T defaults;
  AddProperties(options_class, TableOf(&defaults),
                [](py::handle options) { return TableOf(options.cast<T*>()); });
  options_class.def(
      "validate", [](const T& options) { Validate(options); },
      "Raises ValueError with the first invalid option, its value and its constraint.");
}

}  // namespace surfit::python
