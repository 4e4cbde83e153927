#include <charconv>
#include <sstream>

#include "core/shared_options.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

template <typename Number>
std::string Shortest(Number number) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

template <typename T>
std::string Joined(const std::vector<T>& values) {
  std::string text;
  for (const T& value : values) text += (text.empty() ? "" : ",") + OptionToText(value);
  return text;
}

template <typename Number>
std::vector<Number> Numbers(const std::string& text, const std::string& rule) {
  std::vector<Number> numbers;
  for (const std::string& part : Split(text)) {
    std::istringstream stream(part);
    ThrowIf(!(stream >> numbers.emplace_back()) || stream.peek() != std::char_traits<char>::eof(),
            rule);
  }
  return numbers;
}

class FlagCollector final : public OptionVisitor {
 public:
  std::map<std::string, std::string> values;

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    if (!option.flag.empty()) values[option.flag] = FlagText(option, value);
  }
};

class OptionRecorder final : public OptionVisitor {
 public:
  std::map<std::string, std::string> values;

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    if (!option.flag.empty()) {
      values[option.flag] = FlagText(option, value);
      return;
    }
    Option in_its_unit = option;
    in_its_unit.name.clear();
    values[path_ + option.name] = FlagText(in_its_unit, value);
  }
  bool Enter(const Option& part, const std::type_info&, void*) override {
    lengths_.push_back(path_.size());
    path_ += part.name + ".";
    return true;
  }
  void Leave() override {
    path_.resize(lengths_.back());
    lengths_.pop_back();
  }

  std::string path_;
  std::vector<std::size_t> lengths_;
};

}  // namespace

std::string OptionToText(double number) { return Shortest(number); }
std::string OptionToText(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}
std::string OptionToText(const std::vector<int>& numbers) { return Joined(numbers); }
std::string OptionToText(const std::vector<double>& numbers) { return Joined(numbers); }
std::string OptionToText(const std::optional<double>& number) {
  return number ? OptionToText(*number) : "";
}
void OptionFromText(const std::string& text, std::vector<std::string>* names) {
  *names = Split(text);
}
void OptionFromText(const std::string& text, std::vector<int>* numbers) {
  *numbers = Numbers<int>(text, "whole numbers with commas between them");
}
void OptionFromText(const std::string& text, std::vector<double>* numbers) {
  *numbers = Numbers<double>(text, "numbers with commas between them");
}
void OptionFromText(const std::string& text, std::optional<double>* number) {
  number->reset();
  if (!text.empty()) *number = NumbersFromText(text, 1).front();
}

std::vector<double> NumbersFromText(const std::string& text, std::size_t count) {
  const std::string rule =
      count == 1 ? std::string("1 number") : Concat(count, " numbers with commas between them");
  std::vector<double> numbers = Numbers<double>(text, rule);
  ThrowIf(numbers.size() != count, rule);
  return numbers;
}

std::string FlagText(const Option& option, const OptionValue& value) {
  return std::visit(
      [&](const auto* field) -> std::string {
        using T = std::decay_t<decltype(*field)>;
        if constexpr (std::is_same_v<T, OptionText>) {
          return field->Get();
        } else if constexpr (std::is_same_v<T, std::string>) {
          return *field;
        } else if constexpr (std::is_same_v<T, bool>) {
          return *field ? "true" : "false";
        } else if constexpr (std::is_floating_point_v<T>) {
          return Shortest(option.FlagUnit() == 1 ? *field
                                                 : static_cast<T>(*field / option.FlagUnit()));
        } else {
          return std::to_string(*field);
        }
      },
      value);
}

void SetText(const std::string& name, const std::string& text, OptionText* value) {
  try {
    value->Set(text);
  } catch (const InputError& error) {
    throw InputError(name, " is '", text, "', must be ", error.what());
  }
}

std::map<std::string, std::string> TableFlags(const OptionTable& table) {
  FlagCollector collector;
  table(collector);
  return std::move(collector.values);
}

std::map<std::string, std::string> RecordedValues(const OptionTable& table) {
  OptionRecorder recorder;
  table(recorder);
  return std::move(recorder.values);
}

}  // namespace surfit
