#include "io/openni/openni_library.h"

#include <dlfcn.h>

#include <algorithm>

#include "surfit/core/error.h"

namespace surfit {
namespace {

void* Find(void* library, const char* call, const std::string& name) {
  if (void* const found = dlsym(library, call)) return found;
  throw InputError(name, " has no function ", call, ": it is not OpenNI2");
}

}  // namespace

OpenNiLibrary::OpenNiLibrary(const std::string& name)
    // RTLD_NODELETE: the library must stay loaded, because its drivers run threads.
    : library_(dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) {
  if (library_ == nullptr) {
    throw InputError(
        "OpenNI2 cannot be loaded (", dlerror(),
        "): install the Debian package libopenni2-0, or set openni2_library or LD_LIBRARY_PATH");
  }
#define SURFIT_OPENNI_FIND(call) \
  call = reinterpret_cast<decltype(call)>(Find(library_, #call, name));
  SURFIT_OPENNI_CALLS(SURFIT_OPENNI_FIND)
#undef SURFIT_OPENNI_FIND
  Require(oniInitialize(ONI_API_VERSION), name + " does not start");
}

OpenNiLibrary::~OpenNiLibrary() { oniShutdown(); }

void OpenNiLibrary::Require(OniStatus status, const std::string& what) const {
  if (status != ONI_STATUS_OK) throw InputError(what, ": ", Reason());
}

std::string OpenNiLibrary::Reason() const {
  std::string reason = oniGetExtendedError();
  while (!reason.empty() && (reason.back() == '\n' || reason.back() == '\t')) reason.pop_back();
  std::replace_if(
      reason.begin(), reason.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return reason.empty() ? "OpenNI2 reports no reason" : reason;
}

}  // namespace surfit
