#pragma once

#include <string>

#include "surfit/core/options.h"

namespace surfit::tools {

// Shared library with residuals of the user, for programs that register.
class ResidualLibrary {
 public:
  // Adds the flag --residual_library to the options of a program that has --residual.
  // Returns other options unchanged. The result refers to this object.
  OptionTable With(const OptionTable& options);

  // Loads the library, if one is set, and calls its function SurfitRegisterResiduals(). Call after
  // parsing, before any registration. The library stays loaded. Throws InputError if it cannot be
  // loaded, has no such function, or registers no residual.
  void Load() const;

 private:
  std::string path_;
};

}  // namespace surfit::tools
