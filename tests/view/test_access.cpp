// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <stdexcept>

#include "tools/view/access.h"

namespace stroma::view {
namespace {

TEST(Access, OnlyOwnNamesAreHosts) {
  const Access access("127.0.0.1", 8123);
  for (const char* good : {"127.0.0.1:8123", "localhost:8123"}) {
    EXPECT_TRUE(access.isOurHost(good)) << good;
    EXPECT_TRUE(access.isOurOrigin(std::string("http://") + good)) << good;
  }
  for (const char* bad :
       {"", "127.0.0.1", "127.0.0.1:81234", "127.0.0.1:812", "127.0.0.1.evil.example:8123", "evil.example",
        "localhost.evil.example:8123", "xlocalhost:8123", " localhost:8123", "localhost:8123,evil"}) {
    EXPECT_FALSE(access.isOurHost(bad)) << bad;
    EXPECT_FALSE(access.isOurOrigin(std::string("http://") + bad)) << bad;
  }
  for (const char* bad : {"https://127.0.0.1:8123", "127.0.0.1:8123", "null", "http://127.0.0.1:8123/", "http://"})
    EXPECT_FALSE(access.isOurOrigin(bad)) << bad;
}

TEST(Access, AnAddressThatTheConnectionCameToIsAName) {
  const Access access("0.0.0.0", 8123);
  EXPECT_TRUE(access.address().starts_with("http://127.0.0.1:8123/?token="));
  EXPECT_TRUE(access.isOurHost("192.168.1.5:8123", "192.168.1.5"));
  EXPECT_TRUE(access.isOurOrigin("http://192.168.1.5:8123", "192.168.1.5"));
  EXPECT_TRUE(access.isOurHost("[fd00::2]:8123", "fd00::2"));
  EXPECT_TRUE(access.isOurHost("127.0.0.1:8123", "192.168.1.5"));
  EXPECT_FALSE(access.isOurHost("192.168.1.5:8123"));
  for (const char* bad : {"192.168.1.5", "192.168.1.5:80", "192.168.1.55:8123", "192.168.1.5.evil.example:8123",
                          "192.168.1.6:8123", "0.0.0.0:8123", "[192.168.1.5]:8123", ":8123"})
    EXPECT_FALSE(access.isOurHost(bad, "192.168.1.5")) << bad;
  EXPECT_FALSE(access.isOurHost("fd00::2:8123", "fd00::2"));
  EXPECT_FALSE(access.isOurHost(":8123", ""));
}

TEST(Access, OnlyOriginsThatWereNamedMayShowThePage) {
  EXPECT_EQ(Access("127.0.0.1", 8123).framedBy(), "'none'");
  EXPECT_FALSE(Access("127.0.0.1", 8123).isFramed());
  const Access access("127.0.0.1", 8123, {"http://localhost:8888", "https://[::1]:443"});
  EXPECT_EQ(access.framedBy(), "http://localhost:8888 https://[::1]:443");
  EXPECT_TRUE(access.isFramed());
  // it stays another origin: what it asks for itself it does not get
  EXPECT_FALSE(access.isOurOrigin("http://localhost:8888"));
  for (const char* bad : {"", "*", "localhost:8888", "http://", "http://*", "http://*.example", "http://a b", "http://a;script-src *",
                          "http://a\r\nSet-Cookie: b", "http://localhost:8888/", "file:///", "null", "'self'", "http://a,b"})
    EXPECT_THROW(Access("127.0.0.1", 8123, {"http://localhost:8888", bad}), std::runtime_error) << bad;
}

TEST(Access, AddressesOfTheSixthVersionStandInBrackets) {
  const Access one("::1", 8123), any("::", 8123);
  for (const Access* access : {&one, &any}) {
    EXPECT_TRUE(access->address().starts_with("http://[::1]:8123/?token=")) << access->address();
    EXPECT_TRUE(access->isOurHost("[::1]:8123"));
    EXPECT_TRUE(access->isOurOrigin("http://[::1]:8123"));
    for (const char* bad : {"::1:8123", "[::1]", "[::]:8123", "[::1]:81", "[::1]8123"})
      EXPECT_FALSE(access->isOurHost(bad)) << bad;
  }
}

TEST(Access, ThePortOfHttpMayBeLeftOut) {
  const Access access("192.168.1.5", 80);
  EXPECT_TRUE(access.address().starts_with("http://192.168.1.5/?token="));
  for (const char* good : {"192.168.1.5", "192.168.1.5:80", "localhost", "127.0.0.1:80"}) {
    EXPECT_TRUE(access.isOurHost(good)) << good;
    EXPECT_TRUE(access.isOurOrigin(std::string("http://") + good)) << good;
  }
  EXPECT_TRUE(access.isOurHost("[::1]", "::1"));
  for (const char* bad : {"", "192.168.1.5:8", "192.168.1.5:", "192.168.1.5:8080", "192.168.1.5.evil.example"})
    EXPECT_FALSE(access.isOurHost(bad)) << bad;
}

TEST(Access, TokensAreOfTheirRunAndWhole) {
  const Access one("127.0.0.1", 8123), other("127.0.0.1", 8123);
  EXPECT_EQ(one.token().size(), 32u);
  EXPECT_NE(one.token(), other.token());
  EXPECT_TRUE(one.isToken(one.token()));
  EXPECT_FALSE(one.isToken(other.token()));
  EXPECT_FALSE(one.isToken(""));
  EXPECT_FALSE(one.isToken(one.token().substr(1)));
  EXPECT_FALSE(one.isToken(one.token() + "0"));
  EXPECT_TRUE(one.address().ends_with("/?token=" + one.token()));
}

TEST(Access, TheCookieIsFoundAmongOthersAndNowhereElse) {
  const Access access("127.0.0.1", 8123);
  const std::string pair = "stroma_8123=" + access.token();
  EXPECT_TRUE(access.cookie().starts_with(pair + "; "));
  EXPECT_NE(access.cookie().find("HttpOnly"), std::string::npos);
  EXPECT_NE(access.cookie().find("SameSite=Strict"), std::string::npos);
  for (const std::string& good : {pair, "a=b; " + pair, pair + "; c=d", "a=b;" + pair + " ;c=d"})
    EXPECT_TRUE(access.hasCookie(good)) << good;
  for (const std::string& bad :
       std::vector<std::string>{"", std::string(";"), "x" + pair, pair + "0", "stroma_8124=" + access.token(),
                                "stroma_8123=", "a=" + pair, access.token()})
    EXPECT_FALSE(access.hasCookie(bad)) << bad;
}

}  // namespace
}  // namespace stroma::view
