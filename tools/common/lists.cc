#include "common/lists.h"

#include <sstream>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

template <typename T>
std::vector<T> Parsed(const char* flag, const std::string& text, const char* kind) {
  std::vector<T> values;
  for (const std::string& part : Names(text)) {
    std::istringstream stream(part);
    T value;
    if (!(stream >> value) || stream.peek() != std::char_traits<char>::eof()) {
      throw InputError(
          Concat(flag, " is '", text, "', must be ", kind, " with commas between them"));
    }
    values.push_back(value);
  }
  return values;
}

template <typename T>
std::string JoinedValues(const std::vector<T>& values) {
  std::string text;
  for (const T& value : values) text += (text.empty() ? "" : ",") + Concat(value);
  return text;
}

}  // namespace

std::vector<std::string> Names(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream stream(text);
  for (std::string name; std::getline(stream, name, ',');) names.push_back(name);
  return names;
}

std::vector<double> NumberList(const char* flag, const std::string& text) {
  return Parsed<double>(flag, text, "numbers");
}

std::vector<int> IntegerList(const char* flag, const std::string& text) {
  return Parsed<int>(flag, text, "whole numbers");
}

std::string Joined(const std::vector<double>& numbers) { return JoinedValues(numbers); }
std::string Joined(const std::vector<int>& numbers) { return JoinedValues(numbers); }

}  // namespace surfit::tools
