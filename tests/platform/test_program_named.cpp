// SPDX-License-Identifier: LGPL-2.1-or-later
// Programs are found as a shell finds them.
#include "tools/platform/program_named.h"

#include <optional>

#include "tests/support/folder_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

namespace fs = std::filesystem;

class ProgramNamed : public FolderTest {
 protected:
  void SetUp() override {
    FolderTest::SetUp();
    if (const char* const path = std::getenv("PATH")) before_ = path;
    fs::create_directories(folder_ / "first" / "tool");  // a folder of that name
    for (const char* where : {"second", "third", "fourth"}) write(std::string(where) + "/tool", "#!/bin/sh\n");
    for (const char* where : {"third", "fourth"}) fs::permissions(folder_ / where / "tool", fs::perms::owner_all);
  }
  void TearDown() override {
    before_ ? setenv("PATH", before_->c_str(), 1) : unsetenv("PATH");
    FolderTest::TearDown();
  }
  std::optional<std::string> before_;
};

TEST_F(ProgramNamed, IsTheFirstThatCanBeStarted) {
  setenv("PATH", (file("none") + ":" + file("first") + ":" + file("second") + ":" + file("third") + ":" + file("fourth")).c_str(), 1);
  EXPECT_EQ(programNamed("tool"), file("third/tool"));
  EXPECT_EQ(programNamed("too"), "");
  setenv("PATH", (file("first") + ":" + file("second")).c_str(), 1);
  EXPECT_EQ(programNamed("tool"), "") << "a folder, and a file that is no program";
}

TEST_F(ProgramNamed, IsFoundWhereThisProcessWorks) {
  const fs::path here = fs::current_path();
  fs::current_path(folder_ / "fourth");
  for (const std::string& path : {std::string(":/usr/bin"), file("second") + "::" + file("third")}) {
    setenv("PATH", path.c_str(), 1);
    EXPECT_TRUE(fs::equivalent(programNamed("tool"), folder_ / "fourth" / "tool")) << programNamed("tool");
    EXPECT_TRUE(fs::path(programNamed("tool")).is_absolute());
  }
  fs::current_path(here);
  unsetenv("PATH");
  EXPECT_EQ(programNamed("sh"), fs::exists("/usr/bin/sh") ? "/usr/bin/sh" : "/bin/sh");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
