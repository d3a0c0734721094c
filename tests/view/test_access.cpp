// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

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
