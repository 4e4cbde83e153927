#pragma once

#include <functional>
#include <string>
#include <typeindex>

#include "bindings/bind.h"
#include "surfit/core/options.h"

namespace surfit::python {

// "Name(a=1, b='x')", of all properties of the object's class.
std::string ReprOfOptions(const py::object& options);

// "Name(a=1, b='x')", of the properties that are a number, a text, a switch or None: the others may
// be long.
std::string ReprOfReport(const py::object& report);

// The properties by their names, copied.
py::dict PropertiesOf(const py::object& object);

// What pickle is to do: the same properties come back as a types.SimpleNamespace.
py::tuple ReductionOf(const py::object& report);

// Makes old names of attributes (PresentName()) work, with a DeprecationWarning.
void AddOldNames(py::object python_class);

// What a program says of a frame, a run, ...: Python can print it and, as plain numbers, keep it.
template <typename T>
py::class_<T> BindReport(py::module_& module, const char* name, const char* doc) {
  py::class_<T> report(module, name, doc);
  report.def("__repr__", &ReprOfReport);
  report.def("__reduce__", &ReductionOf,
             "Pickled, it comes back as a types.SimpleNamespace of the same attributes.");
  AddOldNames(report);
  return report;
}

// Sets the named options. Throws TypeError for a name that is none.
void SetOptions(const py::kwargs& values, py::object options);

// How Python sees a field of some type.
struct FieldType {
  std::string name;  // in docstrings
  std::function<py::object(void* field, py::handle options)> get;
  std::function<void(void* field, py::handle value)> set;
};

// Of types that are neither plain nor known here Python sees the text.
void AddFieldType(std::type_index type, FieldType field_type);

// Makes each option of the table a property; `table_of` binds the table to an object.
void AddProperties(py::object options_class, const OptionTable& defaults,
                   const std::function<OptionTable(py::handle)>& table_of);

// A struct of options as a part of nothing but its class: it may lack what is required, as that may
// be set later.
template <typename T>
struct NamedOptions {
  T* options;
  std::string name;

  void Visit(OptionVisitor& v) { v.AddPart(*options, Option(name, "", OptionalPart())); }
};

// Throws InputError naming class, option, value and constraint.
template <typename T>
void RequireValues(T* options, const std::string& name) {
  NamedOptions<T> named = {options, name};
  ValidateTable(TableOf(&named));
}

// A plain struct as a Python class that is made from keywords, which `check` may refuse; its
// attributes are added later.
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
            "Defaults, but for the options named.");
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

// A struct of options, its attributes by its table.
template <typename T>
void BindOptions(py::module_& module, const char* name, const char* doc) {
  namespace py = pybind11;
  py::class_<T> options_class = BindPlain<T>(module, name, doc, &RequireValues<T>);
  T defaults;
  AddProperties(options_class, TableOf(&defaults),
                [](py::handle options) { return TableOf(options.cast<T*>()); });
  options_class.def(
      "validate", [](const T& options) { Validate(options); },
      "Raises ValueError naming an option, its value and the constraint it breaks.");
}

}  // namespace surfit::python
