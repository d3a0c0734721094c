// SPDX-License-Identifier: LGPL-2.1-or-later
// Writing of state files.
#include "framework/simulation/state_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <stdexcept>

#include "framework/scene/output_file.h"
#include "tools/recordings/state_file_marks.h"

namespace stroma {
namespace {

/// Text as gzip members.
class Compressor {
 public:
  Compressor() {
    // level 1: recording must not slow the steps, and digits hardly compress better at a higher level
    constexpr int gzip = 16, window = 15, memory = 8;
    if (deflateInit2(&stream_, 1, Z_DEFLATED, window + gzip, memory, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::bad_alloc();
  }
  Compressor(const Compressor&) = delete;
  ~Compressor() { deflateEnd(&stream_); }

  /// A member of its own. What is returned lives until the next call.
  std::string_view member(std::string_view text) {
    deflateReset(&stream_);
    bytes_.clear();
    int code = Z_OK;
    while (code != Z_STREAM_END) {
      const std::size_t piece = std::min(text.size(), most_), filled = bytes_.size();
      bytes_.resize(filled + std::min(piece, most_) / 2 + 1024);
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
      stream_.avail_in = uInt(piece);
      stream_.next_out = reinterpret_cast<Bytef*>(bytes_.data() + filled);
      stream_.avail_out = uInt(bytes_.size() - filled);
      code = deflate(&stream_, piece == text.size() ? Z_FINISH : Z_NO_FLUSH);
      text.remove_prefix(piece - stream_.avail_in);
      bytes_.resize(bytes_.size() - stream_.avail_out);
    }
    return bytes_;
  }

 private:
  static constexpr std::size_t most_ = 1 << 30;  // zlib counts in 32 bits
  z_stream stream_{};
  std::string bytes_;
};

}  // namespace

void appendNumber(std::string& text, double number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  text.append(digits, end);
}

std::string stateFileName(std::string_view state_path) {
  std::string name(state_path.substr(std::min(state_path.size(), state_path.find_first_not_of('/'))));
  std::replace(name.begin(), name.end(), '/', '.');
  return name + ".state.gz";
}

struct StateWriter::Impl {
  OutputFile file;
  std::unique_ptr<Compressor> compressor;  ///< none: plain text
  std::string text;                        ///< of the instant under way

  void append(std::string_view piece) {
    if (!file.hasFailed()) file.append(compressor ? compressor->member(piece) : piece);
  }
  template <class Point>
  void line(std::string_view label, std::size_t count, Point point) {
    text.append("  ").append(label).append("=");
    for (std::size_t i = 0; i < count; ++i) {
      const auto p = point(i);
      for (int c = 0; c < 3; ++c) appendNumber(text += ' ', p[c]);
    }
    text += '\n';
  }
};

StateWriter::StateWriter(const std::string& path) : impl_(std::make_unique<Impl>()) {
  makeFolderOf(path);
  impl_->file.open(path);
  if (path.ends_with(".gz")) impl_->compressor = std::make_unique<Compressor>();
}

StateWriter::StateWriter(StateWriter&&) noexcept = default;
StateWriter::~StateWriter() = default;

const std::string& StateWriter::path() const { return impl_->file.path(); }

std::optional<double> StateWriter::goOn(double t, bool at_t, const State* state) {
  if (!std::filesystem::is_regular_file(path()) || std::filesystem::file_size(path()) == 0) return std::nullopt;
  const StateRecording recording = readRecording(path(), state);
  if (recording.ends.size() != recording.frames.size())
    throw std::runtime_error(fmt::format("{}: the run cannot go on in this file, which something else wrote", path()));
  std::size_t kept = 0;
  while (kept < recording.frames.size() &&
         (recording.frames[kept].time < t || (at_t && recording.frames[kept].time == t)))
    ++kept;
  if (kept > 0 && recording.ends[kept - 1] == StateRecording::inside_piece)
    throw std::runtime_error(fmt::format("{}: the run cannot continue in this file, which was recompressed", path()));
  impl_->file.keep(kept == 0 ? 0 : recording.ends[kept - 1]);
  if (kept == 0) return std::nullopt;
  return recording.frames[kept - 1].time;
}

void StateWriter::time(double t) {
  finish();
  if (impl_->file.size() == 0) impl_->text.append(state_file_head).append("\n");
  appendNumber(impl_->text += "T= ", t);
  impl_->text += '\n';
}

void StateWriter::rows(std::string_view label, ConstRows rows) {
  impl_->line(label, std::size_t(rows.count), [&](std::size_t i) { return rows[Index(i)]; });
}

void StateWriter::rows(std::string_view label, const std::vector<Vec3>& rows) {
  impl_->line(label, rows.size(), [&](std::size_t i) { return rows[i]; });
}

void StateWriter::rows(std::string_view label, ConstRows rows, const std::vector<int>& indices) {
  impl_->line(label, indices.size(), [&](std::size_t i) { return rows[Index(indices[i])]; });
}

void StateWriter::rows(std::string_view label, const State& state, ConstRows rows, const std::vector<int>& nodes) {
  std::string& text = impl_->text.append("  ").append(label).append("=");
  const Index count = nodes.empty() ? state.nodes() : Index(nodes.size());
  for (Index n = 0; n < count; ++n)
    for (Index k = 0; k < state.rows_per_node; ++k) {
      const Index row = (nodes.empty() ? n : nodes[std::size_t(n)]) * state.rows_per_node + k;
      const int numbers = numbersOf(state.kindOf(row), label);
      for (int c = 0; c < numbers; ++c)
        appendNumber(text += ' ', rows.data[std::size_t(row) * row_doubles + std::size_t(c)]);
    }
  text += '\n';
}

void StateWriter::values(std::string_view name, const std::vector<double>& numbers) {
  std::string& text = impl_->text.append("  @").append(name).append("=");
  for (const double number : numbers) appendNumber(text += ' ', number);
  text += '\n';
}

void StateWriter::finish() {
  std::string& text = impl_->text;
  if (text.empty()) return;
  text += wholeMark(text);
  impl_->append(text);
  text.clear();
}

void StateWriter::close() {
  finish();
  if (impl_->file.size() == 0) impl_->append(std::string(state_file_head) + "\n");
  impl_->append(std::string(state_file_end) + "\n");
  impl_->file.close();
}

}  // namespace stroma
