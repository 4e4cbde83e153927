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

// Tables of options, and the visitors that read or set their values. Options are structs with
// default member values. Each struct has one table of its fields, void Visit(OptionVisitor&
// visitor); with names, help texts and constraints. The table is the source of validation, JSON,
// flags, help texts and Python classes. Example:
//   void CropOptions::Visit(OptionVisitor& v) {
//     v.Add(width_px, "width_px", "width of the image", Positive(), AsFlag());
//   }

// Table entry of a field. The rules are declared below.
struct Option {
  template <typename... Rules>
  Option(std::string field, std::string what, const Rules&... rules)
      : name(std::move(field)), help(std::move(what)) {
    (rules(*this), ...);
  }

  double FlagUnit() const;   // field value for a flag value of 1; degrees for angles
  std::string Help() const;  // help text with choices, unit, bounds and the meaning of zero

  std::string name, help;                                 // name and help text of the field or part
  double min = -std::numeric_limits<double>::infinity();  // bounds in the unit of the field
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false, below_max = false;  // the bound is excluded
  std::string zero, unit;                     // meaning of 0, unit; empty: none
  std::vector<std::string> choices;           // valid texts; empty: all
  bool required = false, everyday = false, repeatable = false, optional_part = false;
  std::string flag;   // empty: no flag
  std::string group;  // set by OptionVisitor
  std::optional<std::vector<std::string>> only_flags;
  std::vector<std::string> without_flags;
};

using OptionRule = std::function<void(Option&)>;

// Rules for numbers. All numbers must be finite.
OptionRule AtLeast(double least);
OptionRule Positive();
OptionRule Below(double limit);  // exclusive upper bound; combined with AtLeast() or Positive()
OptionRule Between(double least, double most);
inline OptionRule Share() { return Between(0, 1); }
OptionRule ZeroIs(const std::string& meaning);  // minimum 0; 0 has this meaning, e.g. "off"
// Rules for texts.
OptionRule OneOf(const std::vector<std::string>& names);
OptionRule Required();  // must not be empty

OptionRule InUnit(const std::string& of_value);  // unit, if the field name does not end in it

// Adds a flag with this name, or with the field name if `as` is empty. An angle in radians (`_rad`)
// gets a flag in degrees (`_deg`).
OptionRule AsFlag(const std::string& as = "");
OptionRule Everyday();    // shown by --help; adds the flag if AsFlag() does not
OptionRule Repeatable();  // each use of the flag adds a value
// Rules for a part, which is a nested struct of options. They select its flags.
OptionRule OnlyFlags(const std::vector<std::string>& flags);
OptionRule WithoutFlags(const std::vector<std::string>& flags);
inline OptionRule NoFlags() { return OnlyFlags({}); }
OptionRule OptionalPart();  // disables Required() in the part

// Field of another type than those of OptionValue, as text. Valid only during the visit.
class OptionText {
 public:
  virtual ~OptionText() = default;
  virtual std::string Get() const = 0;
  // Throws InputError with the violated constraint, without the field name. The field may have
  // changed then.
  virtual void Set(const std::string& text) = 0;
  virtual const std::type_info& type() const = 0;  // of the field
  virtual void* field() = 0;                       // never null
};

// Pointer to a field, to read or set its value.
using OptionValue =
    std::variant<bool*, int*, std::size_t*, float*, double*, std::string*, OptionText*>;

// Conversion to and from text. Overloads for other types are declared with these types. Lists are
// separated by commas, so names must not contain commas or be empty. An empty text is an empty
// list, or std::nullopt. OptionFromText() throws InputError as OptionText::Set().
std::string OptionToText(const std::vector<std::string>& names);
std::string OptionToText(const std::vector<int>& numbers);
std::string OptionToText(const std::vector<double>& numbers);
void OptionFromText(const std::string& text, std::vector<std::string>* names);
void OptionFromText(const std::string& text, std::vector<int>* numbers);
void OptionFromText(const std::string& text, std::vector<double>* numbers);
// Shortest text with the same value. Empty for std::nullopt.
std::string OptionToText(double number);
std::string OptionToText(const std::optional<double>& number);
void OptionFromText(const std::string& text, std::optional<double>* number);
// Throws InputError unless the text has `count` finite numbers, separated by commas.
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

// Base class of visitors of option structs: flags, JSON, Python and validation.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;

  // Sets the group of the following flags. It also applies to parts without a group.
  void Group(const std::string& name) { group_ = name; }

  template <typename T>
  void Add(T& field, const Option& option);
  // Visits a nested struct of options. Rules of its fields apply, and the rules of `option` for
  // parts.
  template <typename T>
  void AddPart(T& part, const Option& option) {
    if (!Enter(option, typeid(T), &part)) return;
    const State outer = EnterState(option);
    part.Visit(*this);
    LeaveState(outer);
    Leave();
  }
  void AddText(OptionText& text, const Option& option) { AddValue(option, &text); }
  template <typename T, typename... Rules>
  void Add(T& field, const char* name, const std::string& help, const Rules&... rules) {
    Add(field, Option(name, help, rules...));
  }
  template <typename T, typename... Rules>
  void AddPart(T& part, const char* name, const std::string& help, const Rules&... rules) {
    AddPart(part, Option(name, help, rules...));
  }
  // Adds a constraint between fields. `check` throws InputError for a violation, without the name
  // of the part. Only validation calls `check`, during the visit.
  virtual void Check(const std::function<void()>& /*check*/) {}

 protected:
  // Called for each field, in the order of the table. `option` is valid during the call.
  virtual void Visit(const Option& option, const OptionValue& value) = 0;
  // Called before a part. Returns true to visit its fields. Leave() follows only in this case.
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
  std::vector<Option> filters_;  // enclosing parts with rules for flags
};

// Table of an object, which must outlive the table.
using OptionTable = std::function<void(OptionVisitor&)>;

template <typename Options>
OptionTable TableOf(Options* options) {
  return [options](OptionVisitor& visitor) { options->Visit(visitor); };
}

// Throws InputError for the first invalid option, like Validate().
void ValidateTable(const OptionTable& table);

// Throws InputError with the field, its value and the constraint for invalid options.
template <typename Options>
void Validate(Options options) {
  ValidateTable(TableOf(&options));
}

// Throws InputError with `name`, the value and the constraint if the value violates a rule. A
// switch (bool) is always valid, and an OptionText is only tested by the rules for texts.
// `in_degrees`: the message has angles in degrees.
void RequireOption(const std::string& name, const Option& option, const OptionValue& value,
                   bool in_degrees = false);

// Flag value as the shortest text with the same value. Angles are rounded by the conversion to
// degrees.
std::string FlagText(const Option& option, const OptionValue& value);
// Calls OptionText::Set(). Throws InputError with the name, the text and the constraint for an
// invalid text.
void SetText(const std::string& name, const std::string& text, OptionText* value);

// Values of all flags by name, as FlagText(). Options without a flag are omitted.
std::map<std::string, std::string> TableFlags(const OptionTable& table);

// Values of all flags by name, for example to save them with results.
template <typename Options>
std::map<std::string, std::string> FlagValues(Options options) {
  return TableFlags(TableOf(&options));
}

namespace internal {

// Text of a field, as in flags.
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
