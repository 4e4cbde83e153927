#include "apps/live/http_rules.h"

#include <arpa/inet.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>

#include "surfit/core/error.h"

namespace surfit {
namespace {

bool IsAddress(int family, const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> address;
  return inet_pton(family, text.c_str(), address.data()) == 1;
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  return text;
}

std::string NameOf(const std::string& host) {
  const std::size_t bracket = host.rfind(']'), colon = host.rfind(':');
  const bool has_port =
      colon != std::string::npos && (bracket == std::string::npos || bracket < colon);
  return Lower(has_port ? host.substr(0, colon) : host);
}

std::string MachineName() {
  std::array<char, 256> name = {};
  if (gethostname(name.data(), name.size() - 1) != 0) return "";
  return Lower(name.data());
}

}  // namespace

std::string RandomToken() {
  std::array<unsigned char, 16> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw InputError("the system has no random numbers for the access token");
  }
  std::string token;
  for (const unsigned char byte : bytes) {
    token += "0123456789abcdef"[byte >> 4];
    token += "0123456789abcdef"[byte & 15];
  }
  return token;
}

bool IsSameSecret(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < b.size(); ++i) {
    const char other = a.empty() ? '\0' : a[i % a.size()];
    difference |= static_cast<unsigned char>(other ^ b[i]);
  }
  return difference == 0;
}

std::uint32_t HttpTarget::Number(const std::string& name) const {
  const auto found = numbers.find(name);
  return found == numbers.end() ? 0 : found->second;
}

std::optional<HttpTarget> ParseTarget(const std::string& target) {
  if (target.empty() || target[0] != '/') return std::nullopt;
  const std::size_t query = target.find('?'), path_end = std::min(query, target.size());
  const std::size_t slash = target.find('/', 1);
  if (slash >= path_end) return std::nullopt;
  HttpTarget parsed;
  parsed.token = target.substr(1, slash - 1);
  parsed.page = target.substr(slash + 1, path_end - slash - 1);
  if (query == std::string::npos) return parsed;
  std::istringstream pairs(target.substr(query + 1));
  for (std::string pair; std::getline(pairs, pair, '&');) {
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos) return std::nullopt;
    std::uint32_t number = 0;
    const char* const end = pair.data() + pair.size();
    const auto [last, error] = std::from_chars(pair.data() + equals + 1, end, number);
    if (error != std::errc() || last != end) return std::nullopt;
    parsed.numbers[pair.substr(0, equals)] = number;
  }
  return parsed;
}

bool IsOwnHost(const std::string& host) {
  const std::string name = NameOf(host);
  if (name == "localhost" || IsAddress(AF_INET, name)) return true;
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') {
    return IsAddress(AF_INET6, name.substr(1, name.size() - 2));
  }
  return !name.empty() && name == MachineName();
}

bool IsOwnOrigin(const std::string& origin, const std::string& host) {
  return Lower(origin) == "http://" + Lower(host);
}

}  // namespace surfit
