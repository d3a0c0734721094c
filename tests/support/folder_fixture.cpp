// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/folder_fixture.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace stroma::test {

void FolderTest::SetUp() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  std::string pattern = testing::TempDir() + info->test_suite_name() + "_" + info->name() + "_XXXXXX";
  std::replace(pattern.begin() + std::ptrdiff_t(testing::TempDir().size()), pattern.end(), '/', '_');
  ASSERT_TRUE(mkdtemp(pattern.data())) << pattern;
  folder_ = pattern;
}
void FolderTest::TearDown() {
  if (!HasFailure()) std::filesystem::remove_all(folder_);
}

void WorkingFolderTest::SetUp() {
  FolderTest::SetUp();
  before_ = std::filesystem::current_path();
  std::filesystem::current_path(folder_);
}
void WorkingFolderTest::TearDown() {
  std::filesystem::current_path(before_);
  FolderTest::TearDown();
}

std::string FolderTest::write(const std::string& name, const std::string& text) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name, std::ios::binary) << text;
  return file(name);
}

}  // namespace stroma::test
