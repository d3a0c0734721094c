// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/whole_file.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace stroma {

namespace fs = std::filesystem;

void writeWholeFile(const std::string& path, const std::string& bytes) {
  const fs::path temporary = path + ".part" + std::to_string(::getpid());
  std::ofstream stream(temporary, std::ios::binary);
  stream.write(bytes.data(), std::streamsize(bytes.size()));
  stream.close();
  std::error_code error;
  if (stream) fs::rename(temporary, path, error);
  if (stream && !error) return;
  std::error_code ignored;
  fs::remove(temporary, ignored);
  throw std::runtime_error(path + " cannot be written" + (error ? ": " + error.message() : ""));
}

}  // namespace stroma
