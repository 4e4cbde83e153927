#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "surfit/core/error.h"

namespace surfit {

// Name of an enum value in options and files. A table is an array of NamedValue.
template <typename T>
struct NamedValue {
  const char* name;
  T value;
};

// Names in the order of the table.
template <typename T, std::size_t kCount>
std::vector<std::string> NamesOf(const NamedValue<T> (&choices)[kCount]) {
  std::vector<std::string> names;
  for (const NamedValue<T>& choice : choices) names.emplace_back(choice.name);
  return names;
}

// "unknown" for a value that is not in the table.
template <typename T, std::size_t kCount>
std::string NameOf(const T& value, const NamedValue<T> (&choices)[kCount]) {
  for (const NamedValue<T>& choice : choices) {
    if (choice.value == value) return choice.name;
  }
  return "unknown";
}

// Returns "a, b, c".
inline std::string JoinNames(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

// Throws InputError "<field> is '<name>', must be one of: ..." for an unknown name.
template <typename T, std::size_t kCount>
T ValueOf(const char* field, const std::string& name, const NamedValue<T> (&choices)[kCount]) {
  for (const NamedValue<T>& choice : choices) {
    if (name == choice.name) return choice.value;
  }
  throw InputError(field, " is '", name, "', must be one of: ", JoinNames(NamesOf(choices)));
}

}  // namespace surfit
