#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace surfit {

// Concatenates streamable values to a string. Numbers have 6 significant digits.
template <typename... Parts>
std::string Concat(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

// Invalid input: a file, a flag or an option. The message is the concatenation of the arguments. It
// names the input, its value and the violated constraint. The tools print "error: ..." and exit
// with status 1.
class InputError : public std::runtime_error {
 public:
  template <typename... Parts>
  explicit InputError(const Parts&... parts) : std::runtime_error(Concat(parts...)) {}
};

// Throws InputError with the message `parts` if `condition` is true.
template <typename... Parts>
void ThrowIf(bool condition, const Parts&... parts) {
  if (condition) throw InputError(parts...);
}

// Returns the result of `work()`. Prepends "`place`: " to the message of an InputError. Other
// exceptions are not changed.
template <typename Work>
auto WithContext(const std::string& place, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(place, ": ", error.what());
  }
}

}  // namespace surfit
