// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/access.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>
#include <random>
#include <stdexcept>

namespace stroma::view {
namespace {

constexpr std::string_view http_port = ":80";  // browsers leave it out

/// An address of IPv6 stands in brackets there.
std::string inUrl(std::string_view address) {
  return address.find(':') == std::string_view::npos ? std::string(address) : fmt::format("[{}]", address);
}

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

/// Scheme, name or address, and port: no path, no wildcard, and nothing that could end a header or a part of it.
bool isOrigin(std::string_view text) {
  const bool is_safe = text.starts_with("https://");
  if (!is_safe && !text.starts_with("http://")) return false;
  text.remove_prefix(is_safe ? 8 : 7);
  const auto isPart = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '-' || c == ':' || c == '[' || c == ']'; };
  return !text.empty() && std::all_of(text.begin(), text.end(), isPart);
}

}  // namespace

Access::Access(const std::string& host, int port, const std::vector<std::string>& framed_by)
    : port_(fmt::format(":{}", port)), token_(randomToken()), name_(fmt::format("stroma_{}", port)) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(host, error);
  const bool is_any = !error && address.is_unspecified();  // no machine is called so
  host_ = inUrl(!is_any ? host : address.is_v6() ? "::1" : "127.0.0.1");
  names_ = {"127.0.0.1", "localhost", host_};
  if (!framed_by.empty()) framed_by_.clear();
  for (const std::string& origin : framed_by) {
    if (!isOrigin(origin))
      throw std::runtime_error(fmt::format("'{}' is no origin of a page: expected one as http://localhost:8888", origin));
    framed_by_ += (framed_by_.empty() ? "" : " ") + origin;
  }
}

std::string Access::address() const {
  return fmt::format("http://{}{}/?token={}", host_, port_ == http_port ? "" : port_, token_);
}

bool Access::names(std::string_view host, std::string_view name) const {
  if (!host.starts_with(name)) return false;
  const std::string_view port = host.substr(name.size());
  return port == port_ || (port.empty() && port_ == http_port);
}

bool Access::isOurHost(std::string_view host, std::string_view local) const {
  if (!local.empty() && names(host, inUrl(local))) return true;
  return std::any_of(names_.begin(), names_.end(), [&](const std::string& name) { return names(host, name); });
}

bool Access::isOurOrigin(std::string_view origin, std::string_view local) const {
  constexpr std::string_view scheme = "http://";
  return origin.starts_with(scheme) && isOurHost(origin.substr(scheme.size()), local);
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
