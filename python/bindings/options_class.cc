#include "bindings/options_class.h"

#include <map>
#include <optional>
#include <vector>

#include "core/shared_options.h"
#include "surfit/core/error.h"
#include "surfit/geometry/rigid3.h"

namespace surfit::python {
namespace {

template <typename T>
std::pair<const std::type_index, FieldType> ValueType(const char* name) {
  return {typeid(T),
          {name, [](void* field, py::handle) { return py::cast(*static_cast<const T*>(field)); },
           [](void* field, py::handle value) { *static_cast<T*>(field) = value.cast<T>(); }}};
}

std::map<std::type_index, FieldType>& FieldTypes() {
  static std::map<std::type_index, FieldType> types = {
      ValueType<bool>("bool"),
      ValueType<int>("int"),
      ValueType<std::size_t>("int"),
      ValueType<float>("float"),
      ValueType<double>("float"),
      ValueType<std::string>("str"),
      ValueType<std::vector<int>>("List[int]"),
      ValueType<std::vector<double>>("List[float]"),
      ValueType<std::vector<std::string>>("List[str]"),
      ValueType<std::optional<double>>("Optional[float]"),
      ValueType<std::optional<std::array<double, 4>>>("Optional[List[float]]"),
      ValueType<std::optional<std::array<double, 5>>>("Optional[List[float]]"),
      ValueType<std::optional<Rigid3d>>("Optional[numpy.ndarray]"),
      {typeid(Eigen::Vector3d),
       {"numpy.ndarray",
        [](void* field, py::handle) { return py::cast(*static_cast<Eigen::Vector3d*>(field)); },
        [](void* field, py::handle value) {
          const auto xyz = value.cast<std::array<double, 3>>();
          *static_cast<Eigen::Vector3d*>(field) = Eigen::Vector3d(xyz.data());
        }}}};
  return types;
}

struct Field {
  const std::type_info* type = nullptr;
  void* address = nullptr;
  OptionText* text = nullptr;  // set if the type has no FieldType
};

Field FieldOf(const OptionValue& value) {
  return std::visit(
      [](auto* field) -> Field {
        using T = std::decay_t<decltype(*field)>;
        if constexpr (std::is_same_v<T, OptionText>) {
          const bool known = FieldTypes().count(field->type()) > 0;
          return known ? Field{&field->type(), field->field()} : Field{nullptr, nullptr, field};
        } else {
          return {&typeid(T), field};
        }
      },
      value);
}

// Calls a function for each field of a struct. A part is a field; its own fields are not visited.
class FieldVisitor final : public OptionVisitor {
 public:
  using Function = std::function<void(const Option&, const Field&)>;
  explicit FieldVisitor(Function function) : function_(std::move(function)) {}

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    function_(option, FieldOf(value));
  }
  bool Enter(const Option& part, const std::type_info& type, void* field) override {
    function_(part, {&type, field});
    return false;
  }

  Function function_;
};

void ForField(const OptionTable& table, const std::string& name,
              const std::function<void(const Field&)>& function) {
  FieldVisitor visitor([&](const Option& option, const Field& field) {
    if (option.name == name) function(field);
  });
  table(visitor);
}

std::string TypeName(const Field& field) {
  return field.text != nullptr ? "str" : FieldTypes().at(*field.type).name;
}

py::object Get(const Field& field, py::handle options) {
  if (field.text != nullptr) return py::str(field.text->Get());
  return FieldTypes().at(*field.type).get(field.address, options);
}

// Paths are accepted as texts.
void Set(const std::string& name, const Field& field, const py::object& value) {
  try {
    const bool is_path = py::hasattr(value, "__fspath__");
    const py::object plain = is_path ? py::object(value.attr("__fspath__")()) : value;
    if (field.text != nullptr) {
      SetText(name, plain.cast<std::string>(), field.text);
    } else {
      FieldTypes().at(*field.type).set(field.address, plain);
    }
  } catch (const py::cast_error&) {
    throw py::type_error(name + " is " + py::repr(value).cast<std::string>() + ", must be " +
                         TypeName(field));
  }
}

std::string ReprOf(const py::object& object, const std::function<bool(py::handle)>& shown) {
  std::string text;
  for (const auto& [name, value] : PropertiesOf(object)) {
    if (!shown(value)) continue;
    text += (text.empty() ? "" : ", ") + name.cast<std::string>() + "=" +
            py::repr(value).cast<std::string>();
  }
  return py::type::of(object).attr("__name__").cast<std::string>() + "(" + text + ")";
}

// Returns the present name of an attribute. Warns if the class has it by another name only.
std::string PresentNameWithWarning(const py::object& self, const std::string& name) {
  const std::string present = PresentName(name);
  if (present == name || py::hasattr(py::type::of(self), name.c_str())) return name;
  const std::string warning = name + " is an old name that version 0.3 drops: use " + present;
  if (PyErr_WarnEx(PyExc_DeprecationWarning, warning.c_str(), 1) != 0)
    throw py::error_already_set();
  return present;
}

}  // namespace

void AddOldNames(py::object python_class) {
  const py::is_method method(python_class);
  // Python calls it for attributes that the class does not have.
  python_class.attr("__getattr__") = py::cpp_function(
      [](const py::object& self, const std::string& name) -> py::object {
        const std::string present = PresentNameWithWarning(self, name);
        if (present != name) return self.attr(present.c_str());
        throw py::attribute_error(Concat("'",
                                         py::type::of(self).attr("__name__").cast<std::string>(),
                                         "' object has no attribute '", name, "'"));
      },
      method);
  python_class.attr("__setattr__") = py::cpp_function(
      [](const py::object& self, const std::string& name, const py::object& value) {
        const py::str present(PresentNameWithWarning(self, name));
        if (PyObject_GenericSetAttr(self.ptr(), present.ptr(), value.ptr()) != 0) {
          throw py::error_already_set();
        }
      },
      method);
}

void AddFieldType(std::type_index type, FieldType field_type) {
  FieldTypes().emplace(type, std::move(field_type));
}

void AddProperties(py::object options_class, const OptionTable& defaults,
                   const std::function<OptionTable(py::handle)>& table_of) {
  py::options docstrings;
  docstrings.disable_function_signatures();  // they do not contain the types of the fields
  const py::object property = py::module_::import("builtins").attr("property");
  const auto class_name = options_class.attr("__name__").cast<std::string>();
  const std::string self = "(self: surfit." + class_name;
  FieldVisitor visitor([&](const Option& option, const Field& field) {
    const std::string name = option.name, type = TypeName(field);
    const std::string full_name = class_name + "." + name;
    const py::cpp_function get(
        [=](const py::object& options) {
          py::object value;
          ForField(table_of(options), name, [&](const Field& f) { value = Get(f, options); });
          return value;
        },
        py::doc((self + ") -> " + type).c_str()));
    const py::cpp_function set(
        [=](const py::object& options, const py::object& value) {
          ForField(table_of(options), name, [&](const Field& f) { Set(full_name, f, value); });
        },
        py::doc((self + ", arg0: " + type + ") -> None").c_str()));
    py::setattr(options_class, name.c_str(), property(get, set, py::none(), option.Help()));
  });
  defaults(visitor);
}

py::dict PropertiesOf(const py::object& object) {
  const py::object property = py::module_::import("builtins").attr("property");
  const py::object copy = py::module_::import("copy").attr("copy");
  py::dict properties;
  for (const auto& item : py::type::of(object).attr("__dict__").attr("items")()) {
    const auto name_and_member = item.cast<py::tuple>();
    if (!py::isinstance(name_and_member[1], property)) continue;
    const py::object name = name_and_member[0];
    const py::object value = object.attr(name);
    // Parts of options are references, which must not outlive the whole.
    properties[name] = py::hasattr(value, "__copy__") ? copy(value) : value;
  }
  return properties;
}

std::string ReprOfOptions(const py::object& options) {
  return ReprOf(options, [](const py::handle&) { return true; });
}

std::string ReprOfReport(const py::object& report) {
  return ReprOf(report, [](const py::handle& value) {
    return value.is_none() || py::isinstance<py::bool_>(value) || py::isinstance<py::int_>(value) ||
           py::isinstance<py::float_>(value) || py::isinstance<py::str>(value);
  });
}

py::tuple ReductionOf(const py::object& report) {
  return py::make_tuple(py::module_::import("types").attr("SimpleNamespace"), py::tuple(),
                        PropertiesOf(report));
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
