// SPDX-License-Identifier: LGPL-2.1-or-later
// Arrays kept on disk from one run to the next, found by a key of all that they depend on.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace stroma {

/// 128 bits over numbers and arrays, in the order in which they are added.
class ContentKey {
 public:
  void add(const void* data, std::size_t bytes);
  template <class T>
  void add(const std::vector<T>& values) {
    const std::uint64_t count = values.size();
    add(&count, sizeof count);
    add(values.data(), values.size() * sizeof(T));
  }
  void add(const std::string& text) { add(text.data(), text.size()); }
  void add(double number) { add(&number, sizeof number); }
  const std::array<std::uint64_t, 2>& value() const { return value_; }
  std::string text() const;  ///< 32 hexadecimal digits

 private:
  std::array<std::uint64_t, 2> value_{0x243f6a8885a308d3ull, 0x13198a2e03707344ull};
};

/// A piece of memory to write.
struct Section {
  const void* data = nullptr;
  std::size_t bytes = 0;
};

/// A file of sections mapped into memory: pages are read when touched. Header: what it is, its format, the key, the
/// places of the sections, and its own check sum. Sections start at multiples of 4096 bytes; check sums of their blocks
/// of 256 KiB are a last section, whose check sum is in the header.
class SectionFile {
 public:
  SectionFile() = default;
  SectionFile(const SectionFile&) = delete;
  SectionFile& operator=(const SectionFile&) = delete;
  ~SectionFile() { close(); }

  /// True when the file is there and whole as far as its header tells. Else `reason` says what is wrong with it: empty
  /// when there is none.
  bool open(const std::string& path, const ContentKey& key, std::size_t sections, std::string& reason);
  Section section(std::size_t i) const;
  template <class T>
  const T* array(std::size_t i) const {
    return static_cast<const T*>(section(i).data);
  }
  /// True when the section is what was written: reads all of it.
  bool isIntact(std::size_t i) const { return isIntact(i, 0, section(i).bytes); }
  /// The same for the blocks that hold a part of it, given in bytes.
  bool isIntact(std::size_t i, std::size_t offset, std::size_t bytes) const;
  bool isOpen() const { return data_ != nullptr; }
  void close();

  /// Writes to a name of its own and renames: whoever reads sees a whole file or none. Removes what runs that were
  /// killed in between have left in the folder. `nameless`: without a name meanwhile, where the file system can.
  /// Returns why not, or empty.
  static std::string write(const std::string& path, const ContentKey& key, const std::vector<Section>& sections,
                           bool nameless = true);

 private:
  const unsigned char* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace stroma
