#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace surfit {

// Joins anything streamable into one string, for messages.
template <typename... Parts>
std::string Concat(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

// Bad input from outside: a file, a flag, an option. The message, joined of its parts, is one
// sentence that names the thing, the value found and the constraint it breaks. Tools print it as
// "error: ..." and exit 1.
class InputError : public std::runtime_error {
 public:
  template <typename... Parts>
  explicit InputError(const Parts&... parts) : std::runtime_error(Concat(parts...)) {}
};

// Throws InputError of the parts if the condition holds.
template <typename... Parts>
void ThrowIf(bool condition, const Parts&... parts) {
  if (condition) throw InputError(parts...);
}

// Returns what `work` returns. If it throws InputError, the place comes first in the message.
template <typename Work>
auto WithPlace(const std::string& place, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(place, ": ", error.what());
  }
}

}  // namespace surfit
