// SPDX-License-Identifier: LGPL-2.1-or-later
// State files, compressed or not, on any bytes. Check sums are put right first: they catch what disks do to a file, and
// what is behind them is to hold as well.
#include "framework/simulation/state_file.h"
#include "tools/recordings/state_file_marks.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace stroma;

/// The text with the sum that each `whole` should have.
std::string sealedRecording(std::string_view text) {
  std::string out;
  std::size_t instant = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view line = text.substr(0, end);
    if (line.starts_with(state_file_whole)) {
      out += wholeMark(std::string_view(out).substr(instant));
      instant = out.size();
    } else {
      out += line;
    }
    text.remove_prefix(end);
  }
  return out;
}

}  // namespace

STROMA_FUZZ_TARGET(recording) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const bool is_marked = bytes.starts_with(state_file_head);
  try {
    const StateRecording recording = readRecording(fuzz::fileWith(is_marked ? sealedRecording(bytes) : bytes));
    std::uint64_t last = 0;
    for (const std::uint64_t end : recording.ends)
      if (end != StateRecording::inside_piece)
        fuzz::require(end > last, "an instant ends before it begins"), last = end;
    fuzz::require(recording.ends.empty() || recording.ends.size() == recording.frames.size(), "instants without ends");
  } catch (const std::runtime_error&) {  // a sentence
  }
  return 0;
}
