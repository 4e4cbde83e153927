#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <variant>
#include <vector>

namespace surfit {

// Options are plain structs: defaults are those of their members. Each struct has one table,
//   void Visit(OptionVisitor& visitor);
// that names its fields and says what they mean and may be. Validation, JSON, flags, help and
// Python's classes follow from it.

// What a table says of a field: its name, what it means, and rules from below.
struct Option {
  template <typename... Rules>
  Option(std::string field, std::string what, const Rules&... rules)
      : name(std::move(field)), help(std::move(what)) {
    (rules(*this), ...);
  }

  double FlagUnit() const;   // a flag's value 1 in the field's unit: a degree of an angle
  std::string Help() const;  // with choices, unit and what zero means

  std::string name, help;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false, below_max = false;  // the bound itself is excluded
  std::string zero, unit;
  std::vector<std::string> choices;
  bool required = false, everyday = false, repeatable = false, optional_part = false;
  std::string flag;   // empty = none
  std::string group;  // set by the visitor
  std::optional<std::vector<std::string>> only_flags;
  std::vector<std::string> without_flags;
};

using OptionRule = std::function<void(Option&)>;

// What a number may be; it must be finite in any case.
OptionRule AtLeast(double least);
OptionRule Positive();
OptionRule Below(double limit);  // besides one of the above
OptionRule Between(double least, double most);
inline OptionRule Share() { return Between(0, 1); }
OptionRule ZeroIs(const std::string& meaning);  // zero is no quantity, but means "off", "all", ...
// What a text may be.
OptionRule OneOf(const std::vector<std::string>& names);
OptionRule Required();  // it must not be empty

OptionRule InUnit(const std::string& of_value);  // where the name does not end in it

// Programs have it as a flag of this name, or of the field's. A field in radians (_rad) is a flag
// in degrees (_deg).
OptionRule AsFlag(const std::string& as = "");
OptionRule Everyday();    // a flag that --help shows
OptionRule Repeatable();  // each further use of the flag adds a value
// Of a part, whose fields are options of their own: which of its flags programs have.
OptionRule OnlyFlags(const std::vector<std::string>& flags);
OptionRule WithoutFlags(const std::vector<std::string>& flags);
inline OptionRule NoFlags() { return OnlyFlags({}); }
OptionRule OptionalPart();  // nothing in the part is Required()

// A field of a type that is read and written as text.
class OptionText {
 public:
  virtual ~OptionText() = default;
  virtual std::string Get() const = 0;
  // Throws InputError that says what the text must be, without naming the field.
  virtual void Set(const std::string& text) = 0;
  virtual const std::type_info& type() const = 0;
  virtual void* field() = 0;
};

using OptionValue =
    std::variant<bool*, int*, std::size_t*, float*, double*, std::string*, OptionText*>;

// How other types are texts: overloads for further ones stand beside their types.
std::string OptionToText(const std::vector<std::string>& names);
std::string OptionToText(const std::vector<int>& numbers);
std::string OptionToText(const std::vector<double>& numbers);
void OptionFromText(const std::string& text, std::vector<std::string>* names);
void OptionFromText(const std::string& text, std::vector<int>* numbers);
void OptionFromText(const std::string& text, std::vector<double>* numbers);
// The shortest text that gives the same number again; an empty one for none.
std::string OptionToText(double number);
std::string OptionToText(const std::optional<double>& number);
void OptionFromText(const std::string& text, std::optional<double>* number);
// Throws InputError unless the text holds so many numbers.
std::vector<double> NumbersFromText(const std::string& text, std::size_t count);

template <std::size_t N>
std::string OptionToText(const std::optional<std::array<double, N>>& numbers) {
  return numbers ? OptionToText(std::vector<double>(numbers->begin(), numbers->end())) : "";
}
template <std::size_t N>
void OptionFromText(const std::string& text, std::optional<std::array<double, N>>* numbers) {
  numbers->reset();
  if (text.empty()) return;
  const std::vector<double> read = NumbersFromText(text, N);
  std::copy(read.begin(), read.end(), numbers->emplace().begin());
}

// Goes through a table.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;

  // To which group the flags that follow belong, those of parts included that do not say.
  void Group(const std::string& name) { group_ = name; }

  template <typename T>
  void Add(T& field, const Option& option);
  // A struct of options.
  template <typename T>
  void AddPart(T& part, const Option& option) {
    if (!Enter(option, typeid(T), &part)) return;
    const State outer = EnterState(option);
    part.Visit(*this);
    LeaveState(outer);
    Leave();
  }
  void AddText(OptionText& text, const Option& option) { AddValue(option, &text); }
  // The same, with what Option is made of.
  template <typename T, typename... Rules>
  void Add(T& field, const char* name, const std::string& help, const Rules&... rules) {
    Add(field, Option(name, help, rules...));
  }
  template <typename T, typename... Rules>
  void AddPart(T& part, const char* name, const std::string& help, const Rules&... rules) {
    AddPart(part, Option(name, help, rules...));
  }
  // What must hold between fields: `check` throws InputError where it does not.
  virtual void Check(const std::function<void()>& /*check*/) {}

 protected:
  virtual void Visit(const Option& option, const OptionValue& value) = 0;
  // Whether to go through the part as well.
  virtual bool Enter(const Option& /*part*/, const std::type_info& /*type*/, void* /*field*/) {
    return true;
  }
  virtual void Leave() {}

 private:
  struct State {
    std::string group;
    std::size_t filters = 0;
    bool optional = false;
  };

  void AddValue(Option option, const OptionValue& value);
  State EnterState(const Option& part);
  void LeaveState(const State& outer);

  std::string group_;
  bool optional_ = false;
  std::vector<Option> filters_;  // parts that leave out flags
};

// A table bound to one struct.
using OptionTable = std::function<void(OptionVisitor&)>;

template <typename Options>
OptionTable TableOf(Options* options) {
  return [options](OptionVisitor& visitor) { options->Visit(visitor); };
}

void ValidateTable(const OptionTable& table);

// Throws InputError naming field, value and constraint.
template <typename Options>
void Validate(Options options) {
  ValidateTable(TableOf(&options));
}

// Throws InputError, naming the option by `name`, where the value breaks what the option says. Of
// angles value and bounds are told in degrees if asked for.
void RequireOption(const std::string& name, const Option& option, const OptionValue& value,
                   bool in_degrees = false);

// A value as its flag has it: text that gives the same value again, angles in degrees.
std::string FlagText(const Option& option, const OptionValue& value);
// Throws InputError naming the option for a text that does not fit.
void SetText(const std::string& name, const std::string& text, OptionText* value);

std::map<std::string, std::string> TableFlags(const OptionTable& table);

// All flags of options with their values, to be kept with results.
template <typename Options>
std::map<std::string, std::string> FlagValues(Options options) {
  return TableFlags(TableOf(&options));
}

namespace internal {

// A field whose type has OptionToText() and OptionFromText().
template <typename T>
class TextOf final : public OptionText {
 public:
  explicit TextOf(T* field) : field_(field) {}
  std::string Get() const override { return OptionToText(*field_); }
  void Set(const std::string& text) override { OptionFromText(text, field_); }
  const std::type_info& type() const override { return typeid(T); }
  void* field() override { return field_; }

 private:
  T* field_;
};

}  // namespace internal

template <typename T>
void OptionVisitor::Add(T& field, const Option& option) {
  if constexpr (std::is_constructible_v<OptionValue, T*>) {
    AddValue(option, &field);
  } else {
    internal::TextOf<T> text(&field);
    AddValue(option, &text);
  }
}

}  // namespace surfit
