// SPDX-License-Identifier: LGPL-2.1-or-later
// Reading of state files.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "framework/mechanics/signs.h"
#include "framework/scene/text.h"
#include "framework/simulation/state_file.h"
#include "tools/recordings/state_file_marks.h"

namespace stroma {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", path, what));
}

/// The text of a file, and where its compressed members end.
struct Contents {
  std::string text;
  std::vector<std::pair<std::size_t, std::uint64_t>> ends;  ///< in the text, in the file; empty for plain text
  bool is_cut = false;                                      ///< the last member has no end
};

std::string bytesOf(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) fail(path, "cannot open (this is a folder)");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, fmt::format("cannot open ({})", std::strerror(errno)));
  return {std::istreambuf_iterator<char>(file), {}};
}

class Inflater {
 public:
  Inflater(const std::string& path, const std::string& bytes) : path_(path), bytes_(bytes) {
    constexpr int gzip = 16, window = 15;
    if (inflateInit2(&stream_, window + gzip) != Z_OK) throw std::bad_alloc();
  }
  Inflater(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&stream_); }

  Contents all() {
    Contents contents;
    std::size_t taken = 0;
    while (taken < bytes_.size() && !contents.is_cut) {
      contents.is_cut = !member(taken, contents.text);
      if (!contents.is_cut) contents.ends.emplace_back(contents.text.size(), taken);
    }
    return contents;
  }

 private:
  /// False when the bytes end before the member does.
  bool member(std::size_t& taken, std::string& text) {
    inflateReset(&stream_);
    for (;;) {
      char buffer[1 << 16];
      const std::size_t piece = std::min<std::size_t>(bytes_.size() - taken, 1 << 30);  // zlib counts in 32 bits
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes_.data() + taken));
      stream_.avail_in = uInt(piece);
      stream_.next_out = reinterpret_cast<Bytef*>(buffer);
      stream_.avail_out = sizeof buffer;
      const int code = inflate(&stream_, Z_NO_FLUSH);
      taken += piece - stream_.avail_in;
      text.append(buffer, sizeof buffer - stream_.avail_out);
      if (code == Z_STREAM_END) return true;
      if (code == Z_BUF_ERROR) return false;
      if (code != Z_OK) fail(path_, fmt::format("the file is damaged ({})", stream_.msg ? stream_.msg : zError(code)));
    }
  }

  const std::string& path_;
  const std::string& bytes_;
  z_stream stream_{};
};

Contents readAll(const std::string& path) {
  std::string bytes = bytesOf(path);
  if (bytes.starts_with("\x1f\x8b")) return Inflater(path, bytes).all();
  Contents contents;
  contents.text = std::move(bytes);
  return contents;
}

/// Takes the next number off `text`; false when there is none.
bool takeNumber(std::string_view& text, double& number) {
  text = text.substr(std::min(text.size(), text.find_first_not_of(" \t\r")));
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return false;
  text.remove_prefix(std::size_t(end - text.data()));
  return text.empty() || text.front() == ' ' || text.front() == '\t' || text.front() == '\r';
}

class StateReader {
 public:
  StateReader(const std::string& path, const State* state) : path_(path), state_(state), contents_(readAll(path)) {}

  StateRecording read() {
    std::string_view text = contents_.text;
    is_marked_ = text.starts_with(state_file_head);
    // a piece without its end has no check sum of its own: all of its text may be there all the same
    if (is_marked_ && contents_.is_cut) text = text.substr(0, contents_.ends.empty() ? 0 : contents_.ends.back().first);
    const std::string_view whole = is_marked_ ? text.substr(0, endOfMarks(text)) : text;
    while (at_ < whole.size()) {
      const auto end = whole.find('\n', at_);
      ++line_;
      if (end == std::string_view::npos) complain("the last line has no end: the file is cut short");
      readLine(whole.substr(at_, end - at_), end + 1);
    }
    if (!is_marked_ && contents_.is_cut) fail(path_, "the file is cut short");
    const bool has_end = text.substr(whole.size()) == fmt::format("{}\n", state_file_end);
    if (is_marked_ && (!has_end || contents_.is_cut)) recording_.unfinished = tellUnfinished();
    return std::move(recording_);
  }

 private:
  [[noreturn]] void complain(const std::string& what) const { fail(fmt::format("{}:{}", path_, line_), what); }

  /// Behind the last whole instant.
  static std::size_t endOfMarks(std::string_view text) {
    for (std::size_t from = text.size(); from != std::string_view::npos && from > 0;) {
      const std::size_t mark = text.rfind(fmt::format("\n{}", state_file_whole), from - 1);
      if (mark == std::string_view::npos) return 0;
      const std::size_t end = text.find('\n', mark + 1);
      if (end != std::string_view::npos) return end + 1;
      from = mark;
    }
    return 0;
  }

  void readLine(std::string_view line, std::size_t next) {
    if (is_marked_ && line.starts_with(state_file_whole)) {
      checkWhole(line, next);
    } else if (const std::string_view words = trimmed(line); !words.empty() && words.front() != '#') {
      readValues(words);
    }
    at_ = next;
  }

  void checkWhole(std::string_view line, std::size_t next) {
    const std::string_view instant = std::string_view(contents_.text).substr(whole_to_, at_ - whole_to_);
    if (fmt::format("{}\n", line) != wholeMark(instant) || recording_.frames.size() != recording_.ends.size() + 1)
      complain("the file is damaged: the check sum of the instant is another");
    recording_.ends.push_back(inFile(next));
    whole_to_ = next;
  }

  std::uint64_t inFile(std::size_t in_text) {
    if (contents_.ends.empty()) return in_text;
    while (member_ < contents_.ends.size() && contents_.ends[member_].first < in_text) ++member_;
    const bool is_known = member_ < contents_.ends.size() && contents_.ends[member_].first == in_text;
    return is_known ? contents_.ends[member_].second : StateRecording::inside_piece;
  }

  std::string tellUnfinished() const {
    if (recording_.frames.empty()) return path_ + ": the file is not finished or cut short, and contains no complete frame";
    return fmt::format("{}: the file is not finished or cut short: its last whole instant is T = {:g} s", path_,
                       recording_.frames.back().time);
  }

  void readValues(std::string_view line) {
    const auto equals = line.find('=');
    const std::string_view label = line.substr(0, equals);
    const bool known = label == "T" || label == "X" || label == "X0" || label == "V" || label == "F" || label.starts_with('@');
    if (equals == std::string_view::npos || !known)
      complain(fmt::format("'{:.20}' is not a line of a state file (expected T=, X=, X0=, V= or F=)", line));
    line.remove_prefix(equals + 1);
    if (label == "T") return readTime(line);
    if (recording_.frames.empty()) complain("values before the first T= line");
    StateFrame& frame = recording_.frames.back();
    if (label.starts_with('@')) return readNumbers(line, frame.values[std::string(label.substr(1))]);
    readRows(line, label, label == "X" ? frame.x : label == "X0" ? frame.x0 : label == "V" ? frame.v : frame.f);
  }

  void readTime(std::string_view line) {
    StateFrame& frame = recording_.frames.emplace_back();
    if (!takeNumber(line, frame.time) || !trimmed(line).empty()) complain("T= must be followed by one number");
  }

  void readNumbers(std::string_view line, std::vector<double>& numbers) {
    if (!numbers.empty()) complain("the same line twice in one frame");
    while (!trimmed(line).empty())
      if (!takeNumber(line, numbers.emplace_back())) complain("a number is damaged");
  }

  void readRows(std::string_view line, std::string_view label, std::vector<Vec3>& rows) {
    if (!rows.empty()) complain("the same line twice in one frame");
    while (!trimmed(line).empty()) {
      const RowKind kind =
          state_ && Index(rows.size()) < state_->size() ? state_->kindOf(Index(rows.size())) : RowKind::place;
      const int numbers = numbersOf(kind, label);
      Eigen::Vector4d values = Eigen::Vector4d::Zero();
      for (int c = 0; c < numbers; ++c)
        if (!takeNumber(line, values[c]))
          complain(
              numbers == 3
                  ? fmt::format("point {} is not three numbers: the file is cut short or damaged", rows.size())
                  : fmt::format("row {} is not {} numbers: the file is cut short or damaged", rows.size(), numbers));
      if (numbers == 4 && !(std::abs(values.norm() - 1) < 1e-3))
        complain(
            fmt::format("row {} is no orientation: its quaternion has the length {:.4g}", rows.size(), values.norm()));
      rows.push_back(numbers == 4 ? signedRotationVector(Quaternion(values.normalized())) : Vec3(values.head<3>()));
    }
  }

  const std::string& path_;
  const State* state_;
  Contents contents_;
  bool is_marked_ = false;
  std::size_t at_ = 0, whole_to_ = 0;  ///< in the text: the line being read; behind the last whole instant
  std::size_t member_ = 0;
  long line_ = 0;
  StateRecording recording_;
};

}  // namespace

StateRecording readRecording(const std::string& path, const State* state) { return StateReader(path, state).read(); }

std::vector<StateFrame> readStateFile(const std::string& path, const State* state) {
  StateRecording recording = readRecording(path, state);
  if (!recording.unfinished.empty()) throw std::runtime_error(recording.unfinished);
  return std::move(recording.frames);
}

}  // namespace stroma
