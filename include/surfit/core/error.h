#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace surfit {

// Bad input from outside: a file, a flag, an option. The message is one sentence that names the
// thing, the value found and the constraint it breaks. Tools print it as "error: ..." and exit 1.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Joins anything streamable into one string, for messages.
template <typename... Parts>
std::string Concat(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

}  // namespace surfit
