// SPDX-License-Identifier: LGPL-2.1-or-later
// Checkpoints on any bytes. Check sums are put right first.
#include <fmt/format.h>
#include <zlib.h>

#include "tests/fuzz/fuzz.h"
#include "tools/session/checkpoint.h"

namespace {

using namespace stroma;

std::string sum(std::string_view bytes) {
  return fmt::format("{:08x}", crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

/// The head with the sum that its last line should have.
std::string sealedCheckpoint(std::string_view bytes) {
  const std::size_t mark = bytes.find("\nend ");
  if (mark == std::string_view::npos) return std::string(bytes);
  const std::size_t data = std::min(bytes.find('\n', mark + 1), bytes.size() - 1) + 1;
  const std::string head(bytes.substr(0, mark + 1));
  return head + "end " + sum(head) + "\n" + std::string(bytes.substr(data));
}

}  // namespace

STROMA_FUZZ_TARGET(checkpoint) {
  try {
    const std::string bytes = sealedCheckpoint({reinterpret_cast<const char*>(data), size});
    Checkpoint checkpoint = Checkpoint::fromBytes(bytes, "fuzz.checkpoint");
    fuzz::require(Checkpoint::fromBytes(checkpoint.bytes(), "again").bytes() == checkpoint.bytes(),
                  "what was written reads back as something else");
    for (const auto& [name, entry] : checkpoint.values.entries())
      fuzz::require(entry.kind == Archive::Kind::text || entry.bytes.size() % 8 == 0, "a list of broken numbers");
  } catch (const std::runtime_error&) {  // a sentence
  }
  return 0;
}
