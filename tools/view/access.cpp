// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/access.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

namespace stroma::view {
namespace {

std::string randomToken() {
  std::random_device source;  // the kernel's
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", source());
  return token;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

Access::Access(const std::string& host, int port)
    : host_(host == "0.0.0.0" ? "127.0.0.1" : host), token_(randomToken()), name_(fmt::format("stroma_{}", port)) {
  for (const std::string& name : {std::string("127.0.0.1"), std::string("localhost"), host})
    names_.push_back(fmt::format("{}:{}", name, port));
}

std::string Access::address() const {
  return fmt::format("http://{}{}/?token={}", host_, names_.front().substr(names_.front().find(':')), token_);
}

bool Access::isOurHost(std::string_view host) const {
  return std::find(names_.begin(), names_.end(), host) != names_.end();
}

bool Access::isOurOrigin(std::string_view origin) const {
  constexpr std::string_view scheme = "http://";
  return origin.starts_with(scheme) && isOurHost(origin.substr(scheme.size()));
}

/// In a time that does not tell how much of it is right.
bool Access::isToken(std::string_view given) const {
  if (given.size() != token_.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < given.size(); ++i) difference |= unsigned(given[i]) ^ unsigned(token_[i]);
  return difference == 0;
}

bool Access::hasCookie(std::string_view cookies) const {
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    const std::string_view one = trimmed(cookies.substr(0, end));
    if (one.starts_with(name_) && one.substr(name_.size()).starts_with('=') && isToken(one.substr(name_.size() + 1)))
      return true;
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
  }
  return false;
}

std::string Access::cookie() const { return fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/", name_, token_); }

}  // namespace stroma::view
