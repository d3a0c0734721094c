// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of cached inverses on any bytes: refused with a reason, or sections that lie in the file. Check sums are put right
// first, by the functions of the source itself, which it shows to nobody else.
#include "components/condensation/section_file.cpp"  // NOLINT(bugprone-suspicious-include)
#include "tests/fuzz/fuzz.h"

namespace {

using namespace stroma;

constexpr std::size_t sections = 3;

/// The file with the sums that its header and its blocks should have, where they lie in it.
std::string sealedSections(std::string bytes) {
  Header header;
  if (bytes.size() < sizeof header) return bytes;
  std::memcpy(&header, bytes.data(), sizeof header);
  header.magic = magic, header.order = byte_order, header.format = format_version;
  header.key = ContentKey().value();
  const auto lies = [&](std::uint64_t start, std::uint64_t length) {
    return start <= bytes.size() && length <= bytes.size() - start;
  };
  std::size_t blocks = 0;
  for (std::size_t i = 0; i < sections && header.sums_start % 8 == 0; ++i) {
    if (!lies(header.start[i], header.bytes[i])) break;
    const Section section{bytes.data() + header.start[i], std::size_t(header.bytes[i])};
    for (std::size_t b = 0; b < header.blocks(i); ++b, ++blocks) {
      const std::uint64_t sum = mixBlock(section, b, i), at = header.sums_start + 8 * blocks;
      if (header.sums_start >= sizeof header && lies(at, 8)) std::memcpy(bytes.data() + at, &sum, 8);
    }
  }
  if (const std::size_t size = header.firstBlock(sections) * 8; lies(header.sums_start, size))
    header.sums_check = mix(bytes.data() + header.sums_start, size, 2);
  header.own_check = ownCheck(header);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

}  // namespace

STROMA_FUZZ_TARGET(cached_inverse) {
  const std::string bytes = sealedSections({reinterpret_cast<const char*>(data), size});
  SectionFile file;
  std::string reason;
  if (!file.open(fuzz::fileWith(bytes), ContentKey(), sections, reason)) {
    fuzz::require(!reason.empty(), "refused without a sentence");
    return 0;
  }
  for (std::size_t i = 0; i < sections; ++i) {
    if (!file.isIntact(i)) continue;
    const Section section = file.section(i);
    std::uint64_t sum = 0;
    for (std::size_t b = 0; b < section.bytes; ++b) sum += static_cast<const unsigned char*>(section.data)[b];
    fuzz::require(sum <= 255 * section.bytes, "a sum is too great");
  }
  return 0;
}
