// SPDX-License-Identifier: LGPL-2.1-or-later
// A folder of its own for the files of each test.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace stroma::test {

/// The folder is fresh, and stays after a failure.
class FolderTest : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  /// Writes a file; its path.
  std::string write(const std::string& name, const std::string& text) const;
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_;
};

/// In that folder.
class WorkingFolderTest : public FolderTest {
 protected:
  void SetUp() override;
  void TearDown() override;

 private:
  std::filesystem::path before_;
};

}  // namespace stroma::test
