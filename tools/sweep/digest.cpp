// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/digest.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <boost/uuid/detail/sha1.hpp>
#include <filesystem>
#include <fstream>

#include "framework/scene/services.h"
#include "tools/session/checkpoint.h"

namespace stroma::sweep {
namespace {

namespace fs = std::filesystem;

/// Size and two check sums: enough to see that a file has changed, at the speed of the disk.
std::string checkSums(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<unsigned char> piece(std::size_t(1) << 20);
  uLong crc = crc32(0, nullptr, 0), adler = adler32(0, nullptr, 0);
  std::uintmax_t size = 0;
  while (stream) {
    stream.read(reinterpret_cast<char*>(piece.data()), std::streamsize(piece.size()));
    const auto count = std::size_t(stream.gcount());
    crc = crc32_z(crc, piece.data(), count), adler = adler32_z(adler, piece.data(), count);
    size += count;
  }
  return fmt::format("{} {:x} {:x}\n", size, crc, adler);
}

}  // namespace

std::string digestOf(const std::string& text) {
  boost::uuids::detail::sha1 sha;
  sha.process_bytes(text.data(), text.size());
  unsigned int words[5];
  sha.get_digest(words);
  return fmt::format("{:08x}{:08x}", words[0], words[1]);
}

std::string digestOfFiles(std::vector<std::string> files) {
  std::ranges::sort(files);
  std::string sums;
  for (const std::string& file : files) sums += checkSums(file);
  return digestOf(sums);
}

std::string digestOfBuild(const std::string& program, const std::vector<std::string>& modules) {
  std::vector<std::string> files(modules);
  files.push_back(program);
  const fs::path folder = moduleFolder();
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(folder, none))
    if (entry.path().extension() == ".so" && entry.path().stem() != "sweep" && entry.path().stem() != "view")
      files.push_back(entry.path().string());
  for (const auto& entry : fs::directory_iterator(folder.parent_path(), none))
    if (entry.path().filename().string().starts_with("libstroma.so")) files.push_back(entry.path().string());
  return digestOf(buildIdentity() + digestOfFiles(files));
}

}  // namespace stroma::sweep
