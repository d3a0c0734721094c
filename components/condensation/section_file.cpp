// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/condensation/section_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "framework/algebra/parallel.h"

namespace stroma {
namespace {

constexpr std::size_t page = 4096, most_sections = 16, block = std::size_t(1) << 18;
constexpr std::array<char, 8> magic{'S', 'T', 'R', 'O', 'M', 'A', 'S', 'F'};
constexpr std::uint32_t format_version = 5, byte_order = 0x01020304;

struct Header {
  std::array<char, 8> magic{};
  std::uint32_t format = 0, order = 0;
  std::array<std::uint64_t, 2> key{};
  std::uint64_t sections = 0, file_size = 0;
  std::array<std::uint64_t, most_sections> start{}, bytes{};
  std::uint64_t sums_start = 0, sums_check = 0, own_check = 0;

  std::size_t blocks(std::size_t section) const { return (bytes[section] + block - 1) / block; }
  /// Of all sections before it.
  std::size_t firstBlock(std::size_t section) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < section; ++i) count += blocks(i);
    return count;
  }
  /// Sections and check sums lie in a file of `size` bytes.
  bool fits(std::uint64_t size) const {
    const auto lies = [&](std::uint64_t at, std::uint64_t length) {
      return at % sizeof(double) == 0 && at <= size && length <= size - at;
    };
    for (std::size_t i = 0; i < sections; ++i)
      if (!lies(start[i], bytes[i])) return false;
    return lies(sums_start, firstBlock(sections) * sizeof(std::uint64_t));
  }
};
static_assert(sizeof(Header) <= page);

constexpr std::uint64_t odd = 0x9e3779b97f4a7c15ull;

/// A bijection. A product moves bits up alone and leaves the highest one to itself; the shift brings them down.
std::uint64_t stirred(std::uint64_t word) {
  word *= odd;
  return word ^ word >> 32;
}

/// Independent sums over words of eight bytes, each over an eighth of the data: eight places are read at once, because
/// what fetches memory ahead stops at the end of each small page.
std::uint64_t mix(const void* data, std::size_t bytes, std::uint64_t seed) {
  constexpr std::size_t ways = 8;
  std::array<std::uint64_t, ways> sums;
  for (std::size_t k = 0; k < ways; ++k) sums[k] = seed + k * odd;
  const auto* from = static_cast<const unsigned char*>(data);
  const auto word = [](const unsigned char* at) {
    std::uint64_t value;
    std::memcpy(&value, at, sizeof value);
    return value;
  };
  const std::size_t length = bytes / (8 * ways) * 8;
  for (std::size_t i = 0; i < length; i += 8)
#pragma GCC unroll 8  // else the sums wait for one another in memory
    for (std::size_t k = 0; k < ways; ++k) sums[k] = stirred(sums[k] ^ word(from + k * length + i));
  std::array<unsigned char, 8 * ways> rest{};
  if (const std::size_t done = ways * length; done < bytes) std::memcpy(rest.data(), from + done, bytes - done);
  for (std::size_t k = 0; k < ways; ++k) sums[k] = stirred(sums[k] ^ word(rest.data() + 8 * k));
  std::uint64_t sum = bytes * odd;
  for (std::uint64_t part : sums) sum = stirred(sum ^ part);
  return sum ^ sum >> 29;
}

/// Of block `i` of a section.
std::uint64_t mixBlock(const Section& section, std::size_t i, std::uint64_t seed) {
  const auto* data = static_cast<const unsigned char*>(section.data) + i * block;
  return mix(data, std::min(block, section.bytes - i * block), seed + i * most_sections);
}

std::uint64_t ownCheck(Header header) {
  header.own_check = 0;
  return mix(&header, sizeof header, 1);
}

std::size_t roundedUp(std::size_t bytes) { return (bytes + page - 1) / page * page; }

bool writeAll(std::FILE* file, const void* data, std::size_t bytes) {
  static const std::array<unsigned char, page> zeros{};
  return (bytes == 0 || std::fwrite(data, 1, bytes, file) == bytes) &&
         std::fwrite(zeros.data(), 1, roundedUp(bytes) - bytes, file) == roundedUp(bytes) - bytes;
}

// ---- names ----

/// A file that is being written. Where the file system can, it has no name until it is whole, so that a run that is
/// killed leaves none. Else it has a name of its own, and a lock by which others see that somebody is at it: the lock
/// ends with the process.
struct Temporary {
  Temporary(const std::string& path, bool nameless) : name(newName(path)) {
    if (nameless) {
      const std::string folder = std::filesystem::path(path).parent_path().string();
      descriptor = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0644);
    }
    unnamed = descriptor >= 0;
    if (unnamed) flock(descriptor, LOCK_EX);  // it will have a name for a moment
    while (descriptor < 0) {
      name = newName(path);
      descriptor = ::open(name.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0644);
      if (descriptor < 0 && errno == EEXIST) continue;
      if (descriptor < 0) return;
      flock(descriptor, LOCK_EX);
      struct stat status {};
      if (fstat(descriptor, &status) == 0 && status.st_nlink > 0) break;
      ::close(descriptor);  // before it was locked it has been taken for a leftover
      descriptor = -1;
    }
    file = fdopen(descriptor, "wb");
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    const int error = errno;
    if (!unnamed) std::remove(name.c_str());
    if (file) std::fclose(file);
    errno = error;
  }

  bool rename(const std::string& path) {
    const std::string own = fmt::format("/proc/self/fd/{}", descriptor);
    if (unnamed && linkat(AT_FDCWD, own.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) != 0) return false;
    unnamed = false;
    return std::rename(name.c_str(), path.c_str()) == 0;
  }

  static std::string newName(const std::string& path) {
    return fmt::format("{}.{}.{}", path, getpid(), std::chrono::steady_clock::now().time_since_epoch().count());
  }

  int descriptor = -1;
  std::FILE* file = nullptr;
  std::string name;
  bool unnamed = false;
};

/// True for names that Temporary gives to files like `path`.
bool isTemporary(const std::string& name, const std::filesystem::path& path) {
  const std::string middle = path.extension().string() + ".";
  const auto at = name.rfind(middle);
  const std::string end = at == std::string::npos ? "" : name.substr(at + middle.size());
  return !end.empty() && end.find_first_not_of("0123456789.") == std::string::npos &&
         std::count(end.begin(), end.end(), '.') == 1;
}

/// Removes what killed runs have left in the folder.
void removeLeftovers(const std::filesystem::path& path) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(path.parent_path(), error)) {
    if (!isTemporary(entry.path().filename().string(), path)) continue;
    const int file = ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(file);
  }
}

}  // namespace

void ContentKey::add(const void* data, std::size_t bytes) {
  for (std::uint64_t& part : value_) part = mix(data, bytes, part);
}

std::string ContentKey::text() const { return fmt::format("{:016x}{:016x}", value_[0], value_[1]); }

bool SectionFile::open(const std::string& path, const ContentKey& key, std::size_t sections, std::string& reason) {
  close();
  reason.clear();
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    if (errno != ENOENT) reason = std::strerror(errno);
    return false;
  }
  struct stat status {};
  const bool known = fstat(file, &status) == 0;
  const std::size_t size = known ? std::size_t(status.st_size) : 0;
  void* memory = size >= page ? mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0) : MAP_FAILED;
  ::close(file);
  if (memory == MAP_FAILED) {
    reason = "it is too short";
    return false;
  }
  data_ = static_cast<const unsigned char*>(memory);
  size_ = size;
  Header header;
  std::memcpy(&header, data_, sizeof header);
  if (header.magic != magic)
    reason = "it is no such file";
  else if (header.order != byte_order || header.format != format_version)
    reason = "it has another format";
  else if (header.own_check != ownCheck(header))
    reason = "its header is damaged";
  else if (header.key != key.value())
    reason = "it is of something else";
  else if (header.sections != sections || header.file_size != size)
    reason = "it is cut short";
  else if (!header.fits(size))
    reason = "its header is damaged";
  else if (mix(data_ + header.sums_start, header.firstBlock(sections) * sizeof(std::uint64_t), 2) != header.sums_check)
    reason = "its check sums are damaged";
  if (reason.empty()) return true;
  close();
  return false;
}

Section SectionFile::section(std::size_t i) const {
  Header header;
  std::memcpy(&header, data_, sizeof header);
  return {data_ + header.start[i], std::size_t(header.bytes[i])};
}

bool SectionFile::isIntact(std::size_t i, std::size_t offset, std::size_t bytes) const {
  Header header;
  std::memcpy(&header, data_, sizeof header);
  const Section found = section(i);
  if (offset > found.bytes || bytes > found.bytes - offset) return false;
  if (bytes == 0) return true;
  const std::size_t first = offset / block, last = (offset + bytes - 1) / block + 1;
#ifdef MADV_POPULATE_READ
  // all pages in one call rather than by a fault each; refusing it costs nothing
  auto* from = static_cast<unsigned char*>(const_cast<void*>(found.data)) + first * block;
  madvise(from, std::min(last * block, found.bytes) - first * block, MADV_POPULATE_READ);
#endif
  const auto* sums = reinterpret_cast<const std::uint64_t*>(data_ + header.sums_start) + header.firstBlock(i);
  std::atomic<bool> intact{true};
  parallelFor(int(last - first), [&](int b) {
    const std::size_t at = first + std::size_t(b);
    if (mixBlock(found, at, i) != sums[at]) intact = false;
  });
  return intact;
}

void SectionFile::close() {
  if (data_) munmap(const_cast<unsigned char*>(data_), size_);
  data_ = nullptr;
}

std::string SectionFile::write(const std::string& path, const ContentKey& key, const std::vector<Section>& sections,
                               bool nameless) {
  Header header{.magic = magic, .format = format_version, .order = byte_order, .key = key.value()};
  header.sections = sections.size();
  std::size_t at = page;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    header.start[i] = at, header.bytes[i] = sections[i].bytes;
    at += roundedUp(sections[i].bytes);
  }
  std::vector<std::uint64_t> sums(header.firstBlock(sections.size()));
  for (std::size_t i = 0; i < sections.size(); ++i)
    parallelFor(int(header.blocks(i)),
                [&](int b) { sums[header.firstBlock(i) + b] = mixBlock(sections[i], std::size_t(b), i); });
  const std::size_t sums_bytes = sums.size() * sizeof(std::uint64_t);
  header.sums_start = at, header.sums_check = mix(sums.data(), sums_bytes, 2);
  header.file_size = at + roundedUp(sums_bytes);
  header.own_check = ownCheck(header);

  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  if (error) return error.message();
  removeLeftovers(path);
  Temporary temporary(path, nameless);
  if (!temporary.file) return std::strerror(errno);
  bool good = writeAll(temporary.file, &header, sizeof header);
  for (const Section& section : sections) good = good && writeAll(temporary.file, section.data, section.bytes);
  good = good && writeAll(temporary.file, sums.data(), sums_bytes);
  good = std::fflush(temporary.file) == 0 && good && fsync(temporary.descriptor) == 0;
  if (good && temporary.rename(path)) return "";
  const std::string reason = std::strerror(errno);
  // a file without a name gets its own through /proc, which a closed room may lack
  return good && nameless ? write(path, key, sections, false) : reason;
}

}  // namespace stroma
