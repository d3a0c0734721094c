// SPDX-License-Identifier: LGPL-2.1-or-later
// Who may see a run: whoever has its token. The address that is printed carries the token once; the page's cookie carries it
// from then on. A name that leads to this machine from elsewhere (DNS rebinding) and pages of other origins are refused by
// exact comparison of Host and Origin. Pages that may show this one in a frame are those named; the cookie reaches a frame only
// where its page is of the same machine by the same name, as localhost is for localhost.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace stroma::view {

class Access {
 public:
  /// `host`: the address that is listened on, which pages may call this machine by, besides 127.0.0.1 and localhost;
  /// `port`: the one that is listened on; `framed_by`: origins of pages that may show this one in a frame. Throws
  /// std::runtime_error for what is no origin.
  Access(const std::string& host, int port, const std::vector<std::string>& framed_by = {});

  const std::string& token() const { return token_; }
  /// "http://127.0.0.1:8123/?token=...". Where all addresses are listened on, the machine's own one.
  std::string address() const;
  /// `local`: the address of this machine that the connection came to, as "192.168.1.5" or "::1": a page may have been
  /// opened by it, which names no other machine. Names are those of the header Host: "[::1]:8123"; port 80 may be left out.
  bool isOurHost(std::string_view host, std::string_view local = {}) const;
  /// Of pages that were loaded from here.
  bool isOurOrigin(std::string_view origin, std::string_view local = {}) const;
  bool isToken(std::string_view given) const;
  /// Whether a header `Cookie` carries the token.
  bool hasCookie(std::string_view cookies) const;
  /// The value of `Set-Cookie`.
  std::string cookie() const;
  /// What follows `frame-ancestors` in the policy of a page: "'none'", or origins.
  const std::string& framedBy() const { return framed_by_; }
  bool isFramed() const { return framed_by_ != no_one; }

 private:
  static constexpr const char* no_one = "'none'";
  bool names(std::string_view host, std::string_view name) const;

  std::string port_;  ///< ":8123"
  std::string host_, token_, name_;
  std::vector<std::string> names_;  ///< without port
  std::string framed_by_ = no_one;
};

}  // namespace stroma::view
