// SPDX-License-Identifier: LGPL-2.1-or-later
// Files that are written whole or not at all.
#include "framework/scene/output_file.h"

#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "tests/support/folder_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

namespace fs = std::filesystem;

class WholeFiles : public FolderTest {
 protected:
  std::size_t entries() const {
    return std::size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
};

std::string textOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(WholeFiles, AreSeenWholeWhenTwoProgramsWriteThemAtOnce) {
  const std::string path = file("shared");
  const auto contents = [](char letter) { return std::string(300000, letter); };
  writeWholeFile(path, contents('a'));
  std::vector<pid_t> writers;
  for (const char letter : {'a', 'b'}) {
    writers.push_back(fork());
    if (writers.back() == 0) {
      for (int i = 0; i < 100; ++i) writeWholeFile(path, contents(letter));
      _exit(0);
    }
  }
  for (int i = 0; i < 100; ++i) {
    const std::string seen = textOf(path);
    EXPECT_TRUE(seen == contents('a') || seen == contents('b')) << seen.size();
  }
  for (const pid_t writer : writers) {
    int status = 0;
    ASSERT_EQ(waitpid(writer, &status, 0), writer);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(entries(), 1u) << "no draft is left";
}

TEST_F(WholeFiles, HaveTheirPiecesOneAfterTheOther) {
  const std::string_view pieces[] = {"the middle, ", "", "and the end"};
  writeWholeFile(file("a"), "what was there before, and longer than what comes");
  writeWholeFile(file("a"), "the start, ", pieces);
  EXPECT_EQ(textOf(file("a")), "the start, the middle, and the end");
  ::testing::internal::CaptureStdout();
  writeWholeFile("/dev/stdout", "the start, ", pieces);  // whose place nothing takes
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "the start, the middle, and the end");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(WholeFiles, TakeNoNameThatSomebodyMayHave) {
  std::ofstream(file("a.part")) << "mine";
  checkWritable(file("a"), true);
  writeWholeFile(file("a"), "new");
  EXPECT_EQ(textOf(file("a.part")), "mine");
  EXPECT_EQ(textOf(file("a")), "new");
  EXPECT_EQ(fs::status(file("a")).permissions(), fs::status(file("a.part")).permissions()) << "those of any new file";
}

/// Rename needs the folder: a file that can itself be written is not enough.
TEST_F(WholeFiles, InAFolderThatCannotBeWrittenInAreFoundBefore) {
  std::ofstream(file("there")) << "old";
  fs::permissions(folder_,
                  fs::perms::owner_read | fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec);
  fs::permissions(file("there"), fs::perms::all);
  const pid_t child = fork();
  if (child == 0) {
    if (geteuid() == 0 && setuid(65534) != 0) _exit(2);
    if (access(file("there").c_str(), W_OK) != 0) _exit(2);
    bool grows = false, is_replaced = false;
    try {
      checkWritable(file("there"));
      grows = true;
      checkWritable(file("there"), true);
      is_replaced = true;
    } catch (const OutputError&) {
    }
    _exit(grows && !is_replaced ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  fs::permissions(folder_, fs::perms::owner_all);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 2) GTEST_SKIP() << "the test's folder is closed to other users";
  EXPECT_EQ(status, 0);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
