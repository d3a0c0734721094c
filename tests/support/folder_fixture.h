// SPDX-License-Identifier: LGPL-2.1-or-later
// A folder of its own for the files of each test.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace stroma::test {

/// The folder is fresh, and stays after a failure.
class FolderTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    std::string pattern = testing::TempDir() + info->test_suite_name() + "_" + info->name() + "_XXXXXX";
    std::replace(pattern.begin() + std::ptrdiff_t(testing::TempDir().size()), pattern.end(), '/', '_');
    ASSERT_TRUE(mkdtemp(pattern.data())) << pattern;
    folder_ = pattern;
  }
  void TearDown() override {
    if (!HasFailure()) std::filesystem::remove_all(folder_);
  }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  /// Writes a file; its path.
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return file(name);
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_;
};

}  // namespace stroma::test
