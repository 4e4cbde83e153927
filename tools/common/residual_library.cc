#include "common/residual_library.h"

#include <dlfcn.h>

#include <filesystem>

#include "common/flags.h"
#include "surfit/core/error.h"
#include "surfit/registration/error_model.h"

namespace surfit::tools {

OptionTable ResidualLibrary::With(const OptionTable& options) {
  if (!HasFlag(options, "residual")) return options;
  return [this, options](OptionVisitor& v) {
    options(v);
    v.Group("registration");
    v.Add(path_, "residual_library",
          "shared library with additional residuals, which are selected by name", AsFlag());
  };
}

void ResidualLibrary::Load() const {
  if (path_.empty()) return;
  const std::string path = std::filesystem::absolute(path_);
  const auto refused = [&](const std::string& why) {
    return InputError(Concat("--residual_library is '", path_, "', which ", why));
  };
  // The library stays loaded, because the residuals are its code.
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw refused(Concat("cannot be loaded: ", dlerror()));
  void* const register_all = dlsym(library, "SurfitRegisterResiduals");
  if (register_all == nullptr) throw refused("has no function SurfitRegisterResiduals");
  const std::size_t before = ResidualTypeNames().size();
  reinterpret_cast<void (*)()>(register_all)();
  if (ResidualTypeNames().size() == before) throw refused("registers no residual");
}

}  // namespace surfit::tools
