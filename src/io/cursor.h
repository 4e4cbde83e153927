#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "surfit/core/error.h"

namespace surfit {

// Reads consecutive little-endian values from untrusted bytes.
class Cursor {
 public:
  // `name` appears in error messages. The bytes and `name` must outlive the cursor.
  Cursor(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  // Number of bytes that were read, and that are left.
  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return bytes_.size() - at_; }
  const std::string& name() const { return name_; }

  // All functions below throw InputError with `name` if too few bytes are left. Bytes() and Take()
  // then read nothing. Returned views refer to the bytes.
  std::string_view Bytes(std::uint64_t count) {
    if (count > left()) {
      throw InputError(name_, " is damaged: it ends ", count - left(), " bytes too early");
    }
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }
  template <typename T>
  T Take() {
    T value{};
    std::memcpy(&value, Bytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  // Reads a 32-bit byte count, then that number of bytes.
  std::string_view Counted() { return Bytes(Take<std::uint32_t>()); }

 private:
  std::string_view bytes_;
  const std::string& name_;
  std::uint64_t at_ = 0;
};

}  // namespace surfit
