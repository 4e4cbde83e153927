#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace surfit {

// 128 bits from the system's source of randomness, as 32 digits. Throws InputError where it has
// none.
std::string RandomToken();

// Whether the texts are the same, in a time that tells nothing of where they differ.
bool IsSameSecret(const std::string& a, const std::string& b);

// What a request asks for: /TOKEN/page?name=1&name=2.
struct HttpTarget {
  std::string token;
  std::string page;
  std::map<std::string, std::uint32_t> numbers;

  std::uint32_t Number(const std::string& name) const;  // 0 where it is not given
};

// Nothing where it is of another form.
std::optional<HttpTarget> ParseTarget(const std::string& target);

// Whether a page under this host (the header, a port may follow) is ours: no name of somebody
// else's that leads here. The machine's addresses, localhost and the machine's own name.
bool IsOwnHost(const std::string& host);

// Whether the origin of a request is a page under its own host.
bool IsOwnOrigin(const std::string& origin, const std::string& host);

}  // namespace surfit
