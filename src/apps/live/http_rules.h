#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace surfit {

// Access token: 128 random bits of the system as 32 hexadecimal digits. Throws InputError if the
// system has no random numbers.
std::string RandomToken();

// Compares two secrets in a time that does not depend on the position of the first difference.
bool IsSameSecret(const std::string& a, const std::string& b);

// Request target of the form /TOKEN/page?name=1&name=2.
struct HttpTarget {
  std::string token;
  std::string page;
  std::map<std::string, std::uint32_t> numbers;

  std::uint32_t Number(const std::string& name) const;  // 0 if missing
};

// Returns std::nullopt for any other form.
std::optional<HttpTarget> ParseTarget(const std::string& target);

// True if the Host header is an IP address, localhost or the name of this machine, with or without
// port. Other host names are rejected, because they may point to this machine by DNS rebinding.
bool IsOwnHost(const std::string& host);

// True if the Origin header is a page of the given host.
bool IsOwnOrigin(const std::string& origin, const std::string& host);

}  // namespace surfit
