// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/output/table_file.h"

#include <fmt/format.h>

#include <filesystem>

#include "framework/scene/diagnostics.h"

namespace stroma {

bool TableFile::open(const std::string& owner, const std::string& path, bool goes_on, const std::string& head) {
  owner_ = owner;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code error;  // opening the file says what is wrong
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  const auto size = std::filesystem::file_size(path, error);
  const bool continues = goes_on && end_ >= 0 && !error && size >= std::uintmax_t(end_);
  if (continues) std::filesystem::resize_file(path, std::uintmax_t(end_), error);
  file_.reset(std::fopen(path.c_str(), continues ? "a" : "w"));
  if (!file_ || (continues && error)) throw ComponentError(fmt::format("{}: cannot write {}", owner, path));
  if (!continues) write(head);
  return !continues;
}

void TableFile::write(const std::string& line) {
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size())
    throw ComponentError(fmt::format("{}: cannot write: is the disk full?", owner_));
}

void TableFile::close() {
  if (!file_) return;
  std::fseek(file_.get(), 0, SEEK_END);
  end_ = std::ftell(file_.get());
  file_.reset();
}

void TableFile::serialize(Archive& archive, const std::string& name) {
  if (file_ && !archive.isReading()) {
    std::fflush(file_.get());
    std::fseek(file_.get(), 0, SEEK_END);
    end_ = std::ftell(file_.get());
  }
  archive.value(name, end_);
}

}  // namespace stroma
