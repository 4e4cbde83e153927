#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "surfit/core/error.h"

namespace surfit {

// Takes little endian values one after the other from bytes that may be anything.
class Cursor {
 public:
  // `name` is told where the bytes end too early; both must outlive the cursor.
  Cursor(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return bytes_.size() - at_; }
  const std::string& name() const { return name_; }

  // All throw InputError naming `name` if fewer bytes are left.
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
  // As many bytes as the 32-bit number before them says.
  std::string_view Counted() { return Bytes(Take<std::uint32_t>()); }

 private:
  std::string_view bytes_;
  const std::string& name_;
  std::uint64_t at_ = 0;
};

}  // namespace surfit
