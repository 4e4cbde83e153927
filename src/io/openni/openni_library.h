#pragma once

#include <OniCAPI.h>

#include <string>

namespace surfit {

// The functions of OpenNI2 that are used here.
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

// OpenNI2, loaded when it is asked for and initialised while this lives: programs do not link it,
// for they need not have it.
class OpenNiLibrary {
 public:
  // `name` as for dlopen(). Throws InputError where it cannot be loaded, is another library, or
  // does not initialise.
  explicit OpenNiLibrary(const std::string& name);
  ~OpenNiLibrary();
  OpenNiLibrary& operator=(OpenNiLibrary&&) = delete;

// NOLINTNEXTLINE(bugprone-macro-parentheses): a member has its name
#define SURFIT_OPENNI_MEMBER(call) decltype(&::call) call = nullptr;
  SURFIT_OPENNI_CALLS(SURFIT_OPENNI_MEMBER)
#undef SURFIT_OPENNI_MEMBER

  // Throws InputError unless `status` is OK: what could not be done, and OpenNI2's reason.
  void Require(OniStatus status, const std::string& what) const;
  // Its reason for the last failure, in one line.
  std::string Reason() const;

 private:
  void* library_ = nullptr;
};

}  // namespace surfit
