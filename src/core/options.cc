#include "surfit/core/options.h"

#include <cmath>

#include "core/named_values.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string Alternatives(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 < names.size() ? ", " : " or ";
    text += names[i];
  }
  return text;
}

// Constraint of a number as text, with bounds divided by `unit`.
std::string NumberRule(const Option& option, double unit) {
  const double min = option.min / unit, max = option.max / unit;
  if (std::isinf(min)) return "finite";
  const bool two_sided = std::isfinite(max) && !option.above_min && !option.below_max;
  if (two_sided) return Concat("from ", min, " to ", max);
  std::string rule = Concat(option.above_min ? "above " : "at least ", min);
  if (min == 0) {
    const std::string zero = option.zero.empty() ? "zero" : "zero (" + option.zero + ")";
    rule = option.above_min ? "positive" : zero + " or positive";
  }
  if (std::isfinite(max)) rule += Concat(" and ", option.below_max ? "below " : "at most ", max);
  return rule;
}

std::string Bounds(const Option& option, double unit) {
  const bool two_sided = !option.above_min && !option.below_max && option.zero.empty();
  if (two_sided) return Concat(option.min / unit, " to ", option.max / unit);
  return Concat(option.below_max ? "below " : "at most ", option.max / unit);
}

bool IsInside(const Option& option, double value) {
  if (!std::isfinite(value)) return false;
  return (option.above_min ? value > option.min : value >= option.min) &&
         (option.below_max ? value < option.max : value <= option.max);
}

class Validator final : public OptionVisitor {
 public:
  void Check(const std::function<void()>& check) override {
    try {
      check();
    } catch (const InputError& error) {
      if (path_.empty()) throw;
      throw InputError(path_.substr(0, path_.size() - 1), ": ", error.what());
    }
  }

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    RequireOption(path_ + option.name, option, value);
  }
  bool Enter(const Option& part, const std::type_info&, void*) override {
    path_ += part.name + ".";
    return true;
  }
  void Leave() override { path_.erase(path_.rfind('.', path_.size() - 2) + 1); }

  std::string path_;
};

}  // namespace

OptionRule AtLeast(double least) {
  return [=](Option& o) { o.min = least; };
}
OptionRule Positive() {
  return [](Option& o) { o.min = 0, o.above_min = true; };
}
OptionRule Below(double limit) {
  return [=](Option& o) { o.max = limit, o.below_max = true; };
}
OptionRule Between(double least, double most) {
  return [=](Option& o) { o.min = least, o.max = most; };
}
OptionRule ZeroIs(const std::string& meaning) {
  return [=](Option& o) { o.min = 0, o.zero = meaning; };
}
OptionRule OneOf(const std::vector<std::string>& names) {
  return [=](Option& o) { o.choices = names; };
}
OptionRule Required() {
  return [](Option& o) { o.required = true; };
}
OptionRule InUnit(const std::string& of_value) {
  return [=](Option& o) { o.unit = of_value; };
}
OptionRule AsFlag(const std::string& as) {
  return [=](Option& o) {
    o.flag = as.empty() ? o.name : as;
    if (EndsWith(o.flag, "_rad")) o.flag.replace(o.flag.size() - 3, 3, "deg");
  };
}
OptionRule Everyday() {
  return [](Option& o) {
    o.everyday = true;
    if (o.flag.empty()) AsFlag()(o);
  };
}
OptionRule Repeatable() {
  return [](Option& o) { o.repeatable = true; };
}
OptionRule OnlyFlags(const std::vector<std::string>& flags) {
  return [=](Option& o) { o.only_flags = flags; };
}
OptionRule WithoutFlags(const std::vector<std::string>& flags) {
  return [=](Option& o) { o.without_flags = flags; };
}
OptionRule OptionalPart() {
  return [](Option& o) { o.optional_part = true; };
}

double Option::FlagUnit() const { return EndsWith(name, "_rad") ? kDegree : 1; }

std::string Option::Help() const {
  std::string text = help;
  if (!choices.empty()) text += "; one of " + Alternatives(choices);
  if (!unit.empty()) text += ", " + unit;
  const bool share = min == 0 && max == 1;
  if (std::isfinite(max) && !share) text += ", " + Bounds(*this, flag.empty() ? 1 : FlagUnit());
  if (!zero.empty()) text += "; 0 = " + zero;
  return text;
}

void RequireOption(const std::string& name, const Option& option, const OptionValue& value,
                   bool in_degrees) {
  std::visit(
      [&](const auto* field) {
        using T = std::decay_t<decltype(*field)>;
        std::string text;
        if constexpr (std::is_same_v<T, OptionText>) {
          text = field->Get();
        } else if constexpr (std::is_same_v<T, std::string>) {
          text = *field;
        } else if constexpr (!std::is_same_v<T, bool>) {
          if (IsInside(option, static_cast<double>(*field))) return;
          const double unit = in_degrees ? option.FlagUnit() : 1;
          throw InputError(name, " is ", *field / unit, ", must be ", NumberRule(option, unit));
        }
        ThrowIf(option.required && text.empty(), name, " is missing, must be set");
        if (!option.choices.empty() && !Contains(option.choices, text)) {
          throw InputError(name, " is '", text, "', must be one of: ", JoinNames(option.choices));
        }
      },
      value);
}

void OptionVisitor::AddValue(Option option, const OptionValue& value) {
  option.group = group_;
  if (optional_) option.required = false;
  for (const Option& part : filters_) {
    const bool kept = !part.only_flags || Contains(*part.only_flags, option.flag);
    if (!kept || Contains(part.without_flags, option.flag)) option.flag.clear();
  }
  Visit(option, value);
}

OptionVisitor::State OptionVisitor::EnterState(const Option& part) {
  State outer = {group_, filters_.size(), optional_};
  if (part.only_flags || !part.without_flags.empty()) filters_.push_back(part);
  optional_ = optional_ || part.optional_part;
  return outer;
}

void OptionVisitor::LeaveState(const State& outer) {
  group_ = outer.group;
  filters_.erase(filters_.begin() + static_cast<std::ptrdiff_t>(outer.filters), filters_.end());
  optional_ = outer.optional;
}

void ValidateTable(const OptionTable& table) {
  Validator validator;
  table(validator);
}

}  // namespace surfit
