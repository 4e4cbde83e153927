#pragma once

#include <OniCAPI.h>

#include <string>

namespace surfit {

#define SURFIT_OPENNI_CALLS(X)     \
  X(oniInitialize)                 \
  X(oniShutdown)                   \
  X(oniGetExtendedError)           \
  X(oniGetDeviceList)              \
  X(oniReleaseDeviceList)          \
  X(oniRegisterDeviceCallbacks)    \
  X(oniUnregisterDeviceCallbacks)  \
  X(oniWaitForAnyStream)           \
  X(oniDeviceOpen)                 \
  X(oniDeviceClose)                \
  X(oniDeviceGetInfo)              \
  X(oniDeviceGetSensorInfo)        \
  X(oniDeviceCreateStream)         \
  X(oniDeviceSetProperty)          \
  X(oniDeviceEnableDepthColorSync) \
  X(oniStreamDestroy)              \
  X(oniStreamStart)                \
  X(oniStreamStop)                 \
  X(oniStreamReadFrame)            \
  X(oniStreamSetProperty)          \
  X(oniStreamGetProperty)          \
  X(oniFrameRelease)               \
  X(oniDeviceIsImageRegistrationModeSupported)

// OpenNI2, loaded with dlopen() by the constructor, so that programs run without it. The destructor
// calls oniShutdown(). The code stays loaded. Members are the functions of OniCAPI.h.
class OpenNiLibrary {
 public:
  // `name`: argument of dlopen(). Throws InputError if loading or initialisation fails, or the file
  // is another library.
  explicit OpenNiLibrary(const std::string& name);
  ~OpenNiLibrary();
  OpenNiLibrary& operator=(OpenNiLibrary&&) = delete;

// NOLINTNEXTLINE(bugprone-macro-parentheses): `call` is the name of a member
#define SURFIT_OPENNI_MEMBER(call) decltype(&::call) call = nullptr;
  SURFIT_OPENNI_CALLS(SURFIT_OPENNI_MEMBER)
#undef SURFIT_OPENNI_MEMBER

  // Throws InputError with `what` and the reason of OpenNI2 unless `status` is OK.
  void Require(OniStatus status, const std::string& what) const;
  // Error message of the last failure, in one line, never empty.
  std::string Reason() const;

 private:
  void* library_ = nullptr;
};

}  // namespace surfit
