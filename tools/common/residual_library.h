#pragma once

#include <string>

#include "surfit/core/options.h"

namespace surfit::tools {

// A library of residuals of a user's own, which programs that register can load.
class ResidualLibrary {
 public:
  // The options of a program, with the flag that names the library where one of them is a residual.
  OptionTable With(const OptionTable& options);

  // Loads it, if one is named, and has it register its residuals. Throws InputError if it cannot be
  // loaded, or registers none.
  void Load() const;

 private:
  std::string path_;
};

}  // namespace surfit::tools
