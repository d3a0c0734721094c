// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/checkpoint.h"

#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "framework/scene/abi.h"
#include "framework/scene/output_file.h"

namespace stroma {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are stored as they lie in memory");
constexpr std::string_view first_line = "stroma checkpoint 1";

unsigned long checkSum(std::string_view bytes) {
  return crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

/// Takes lines off the head, and counts what it took.
class Head {
 public:
  Head(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}
  [[noreturn]] void damaged(const std::string& what) const {
    throw std::runtime_error(fmt::format("{}: {}", name_, what));
  }
  std::string_view line() {
    const auto end = bytes_.find('\n', at_);
    if (end == std::string_view::npos) damaged("the checkpoint is cut short");
    const std::string_view line = bytes_.substr(at_, end - at_);
    before_ = at_;
    at_ = end + 1;
    return line;
  }
  /// The rest of a line that starts with `word`.
  std::string field(std::string_view word) {
    const std::string_view text = line();
    if (!text.starts_with(word) || text.size() <= word.size()) damaged("the checkpoint is damaged");
    return std::string(text.substr(word.size() + 1));
  }
  std::string_view beforeLastLine() const { return bytes_.substr(0, before_); }
  std::size_t position() const { return at_; }

 private:
  std::string_view bytes_;
  const std::string& name_;
  std::size_t at_ = 0, before_ = 0;
};

struct Stored {
  std::string name;
  Archive::Kind kind;
  std::size_t bytes;
  unsigned long sum;
};

Stored parseValue(std::string_view line, const Head& head) {
  std::istringstream words{std::string(line)};
  std::string word, kind, sum;
  std::size_t count = 0;
  Stored stored{};
  words >> word >> kind >> count >> sum >> std::ws;
  std::getline(words, stored.name);
  if (!words || word != "value" || kind.size() != 1) head.damaged("the checkpoint is damaged");
  stored.kind = Archive::Kind(kind[0]);
  stored.bytes = stored.kind == Archive::Kind::text ? count : 8 * count;
  stored.sum = std::strtoul(sum.c_str(), nullptr, 16);
  return stored;
}

}  // namespace

std::string buildIdentity() { return STROMA_ABI; }

std::string Checkpoint::head() const {
  std::string text = fmt::format("{}\nscene {}\nbuild {}\n", first_line, scene, build);
  for (const auto& [name, entry] : values.entries()) {
    const std::size_t each = entry.kind == Archive::Kind::text ? 1 : 8;
    text += fmt::format("value {} {} {:08x} {}\n", char(entry.kind), entry.bytes.size() / each, checkSum(entry.bytes),
                        name);
  }
  return text + fmt::format("end {:08x}\n", checkSum(text));
}

std::string Checkpoint::bytes() const {
  std::string text = head();
  std::size_t size = 0;
  for (const auto& [name, entry] : values.entries()) size += entry.bytes.size();
  text.reserve(text.size() + size);
  for (const auto& [name, entry] : values.entries()) text += entry.bytes;
  return text;
}

Checkpoint Checkpoint::fromBytes(const std::string& bytes, const std::string& name) {
  Head head(bytes, name);
  if (!bytes.starts_with(first_line))
    head.damaged(fmt::format("this is no checkpoint (expected a file that starts with '{}')", first_line));
  head.line();
  Checkpoint checkpoint;
  checkpoint.scene = head.field("scene");
  checkpoint.build = head.field("build");
  std::vector<Stored> list;
  std::string_view line = head.line();
  for (; !line.starts_with("end "); line = head.line()) list.push_back(parseValue(line, head));
  if (fmt::format("end {:08x}", checkSum(head.beforeLastLine())) != line) head.damaged("the checkpoint is damaged");
  std::map<std::string, Archive::Entry> entries;
  std::size_t at = head.position();
  for (const Stored& stored : list) {
    if (stored.bytes > bytes.size() - at) head.damaged("the checkpoint is cut short");
    std::string data = bytes.substr(at, stored.bytes);
    if (checkSum(data) != stored.sum) head.damaged(fmt::format("the checkpoint is damaged: {}", stored.name));
    entries[stored.name] = {stored.kind, std::move(data), false};
    at += stored.bytes;
  }
  if (at != bytes.size()) head.damaged("the checkpoint has more bytes than it says");
  checkpoint.values = Archive(std::move(entries));
  return checkpoint;
}

void Checkpoint::write(const std::string& path) const {
  makeFolderOf(path);
  std::vector<std::string_view> data;  // as it lies: a large body's is not copied
  for (const auto& [name, entry] : values.entries()) data.push_back(entry.bytes);
  writeWholeFile(path, head(), data);
}

Checkpoint Checkpoint::read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("{}: cannot open ({})", path, std::strerror(errno)));
  return fromBytes(std::string{std::istreambuf_iterator<char>(file), {}}, path);
}

}  // namespace stroma
