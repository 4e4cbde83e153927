#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace surfit {

// Random access token: 128 bits as 32 hexadecimal digits. Throws InputError if the system has no
// random numbers.
std::string RandomToken();

// Compares secrets without leaking the position of a difference by timing.
bool IsSameSecret(const std::string& a, const std::string& b);

// Parsed request target /TOKEN/page?name=1&name=2.
struct HttpTarget {
  std::string token;
  std::string page;
  std::map<std::string, std::uint32_t> numbers;

  std::uint32_t Number(const std::string& name) const;  // 0 if missing
};

// Returns std::nullopt for other forms. Does not check the token.
std::optional<HttpTarget> ParseTarget(const std::string& target);

// Returns whether a Host header is an IP address, localhost or the name of this machine, with or
// without a port. Rejecting other names prevents DNS rebinding.
bool IsOwnHost(const std::string& host);

// Returns whether an Origin header belongs to the Host header.
bool IsOwnOrigin(const std::string& origin, const std::string& host);

}  // namespace surfit
