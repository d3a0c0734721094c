// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/output/table_file.h"

#include <fmt/format.h>

#include <filesystem>

namespace stroma {

bool TableFile::open(const std::string& path, bool goes_on, const std::string& head) {
  makeFolderOf(path);
  file_.open(path);
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  // a run that goes on elsewhere starts a file of its own
  const bool continues = goes_on && end_ >= 0 && !error && size > 0;
  if (continues && size < std::uintmax_t(end_))
    throw std::runtime_error(
        fmt::format("{}: the run cannot go on in this file: it has {} bytes, and had {} when the "
                    "checkpoint was written",
                    path, size, end_));
  if (continues)
    file_.keep(std::uint64_t(end_));
  else
    write(head);
  return !continues;
}

void TableFile::write(const std::string& lines) {
  if (!file_.hasFailed()) file_.append(lines);
}

void TableFile::close() {
  if (!file_.isOpen()) return;
  end_ = static_cast<long long>(file_.size());
  file_.close();
}

void TableFile::serialize(Archive& archive, const std::string& name) {
  if (file_.isOpen() && !archive.isReading()) end_ = static_cast<long long>(file_.size());
  archive.value(name, end_);
}

}  // namespace stroma
