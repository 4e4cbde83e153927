#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bindings/field_count.h"
#include "bindings/pose_caster.h"

namespace surfit::python {

// One sentence for each options struct with a field that is no attribute of its class.
std::vector<std::string>& IncompleteOptions();

// "Name(a=1, b='x')", of all properties of the object's class.
std::string ReprOfOptions(const pybind11::object& options);

// Sets the named options. Throws TypeError for a name that is none.
void SetOptions(const pybind11::kwargs& values, pybind11::object options);

template <typename T, typename = void>
struct HasValidate : std::false_type {};
template <typename T>
struct HasValidate<T, std::void_t<decltype(std::declval<const T&>().Validate())>> : std::true_type {
};

// Makes a plain struct of options a Python class: made from keywords, each field an attribute.
template <typename T>
class OptionsClass {
 public:
  OptionsClass(pybind11::module_& module, const char* name, const char* doc)
      : name_(name), class_(module, name, doc) {
    namespace py = pybind11;
    class_.def(py::init(&FromKeywords), "Defaults, but for the options named.");
    class_.def("__repr__", &ReprOfOptions);
    class_.def("__copy__", [](const T& options) { return T(options); });
    class_.def(
        "__deepcopy__", [](const T& options, const py::dict&) { return T(options); },
        py::arg("memo"));
    if constexpr (HasValidate<T>::value) {
      class_.def(
          "validate", [](const T& options) { options.Validate(); },
          "Raises ValueError naming an option, its value and the constraint it breaks.");
    }
  }

  template <typename Field>
  OptionsClass& Add(const char* name, Field T::*field, const char* doc) {
    class_.def_readwrite(name, field, doc);
    ++count_;
    return *this;
  }
  // A field that Python sees as something else.
  template <typename Getter, typename Setter>
  OptionsClass& AddProperty(const char* name, Getter get, Setter set, const char* doc) {
    class_.def_property(name, get, set, doc);
    ++count_;
    return *this;
  }

  // To be called after all fields, of structs that FieldCount() is for.
  void Complete() const {
    const std::size_t fields = FieldCount<T>();
    if (fields == count_) return;
    IncompleteOptions().push_back(name_ + " has " + std::to_string(fields) + " fields, " +
                                  std::to_string(count_) + " of them are attributes in Python");
  }

 private:
  static T FromKeywords(const pybind11::kwargs& values) {
    T options;
    SetOptions(values, pybind11::cast(&options, pybind11::return_value_policy::reference));
    return options;
  }

  std::string name_;
  pybind11::class_<T> class_;
  std::size_t count_ = 0;
};

}  // namespace surfit::python
